// SPDX-License-Identifier: Apache-2.0
/// @file lattice_transform.h
/// Transforms of lattices with voxels of any size. OpenVDB refuses transforms whose determinant is below 3e-15, i.e.
/// voxels of 1.44e-5, as if the matrix were singular. Nevertheless it reads, copies and computes with a smaller uniform
/// scale as long as nothing is added to it, so such a scale works within this program. Other programs refuse it, so it
/// is not written to VDBs for them.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Whether OpenVDB makes a transform with this scale.
bool isOrdinaryScale(const openvdb::Vec3d& scale);

/// Whether voxels are cubes, rotated or not, to the precision of a matrix of floats. OpenVDB's own test depends, for
/// rotated voxels, on the last bit of a cube root.
bool hasCubicVoxels(const openvdb::GridBase& grid);

/// Node (i, j, k) lies at @a voxelSize * (i, j, k).
openvdb::math::Transform::Ptr latticeTransform(double voxelSize);

/// The transform of every second node of the lattice.
openvdb::math::Transform::Ptr coarserTransform(const openvdb::math::Transform& fine);

}  // namespace vdbtools
