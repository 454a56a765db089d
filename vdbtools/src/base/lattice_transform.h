// SPDX-License-Identifier: Apache-2.0
/// @file lattice_transform.h
/// Transforms of lattices with voxels of any size. OpenVDB makes none whose determinant is below 3e-15, that of voxels
/// of 1.44e-5, as if its matrix were singular. It reads, copies and computes with a uniform scale below that all the
/// same, as long as nothing is added to it, so such a scale serves within this program. Other programs refuse it, so it
/// goes into no VDB that is for others.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Whether OpenVDB makes a transform with this scale.
bool isOrdinaryScale(const openvdb::Vec3d& scale);

/// Node (i, j, k) lies at @a voxelSize * (i, j, k).
openvdb::math::Transform::Ptr latticeTransform(double voxelSize);

/// Of every second node of the lattice.
openvdb::math::Transform::Ptr coarserTransform(const openvdb::math::Transform& fine);

}  // namespace vdbtools
