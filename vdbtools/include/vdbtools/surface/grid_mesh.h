// SPDX-License-Identifier: Apache-2.0
/// @file grid_mesh.h
/// Converts any level set to a mesh, by the same marching cubes as for a fractal: closed and 2-manifold. A vertex lies
/// where the grid, interpolated linearly along the edge, is 0. For a fractal the result is a coarse approximation; its
/// own field gives the true surface.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

namespace vdbtools {

/// Positions are in the grid's world space. The mesh has no normals; see computeNormals().
/// @param levelSet  negative inside; a positive background
/// @throw DataError  no change of sign, values that are not finite
Mesh meshOfLevelSet(const openvdb::FloatGrid& levelSet, Monitor& monitor);

/// The distances to the mesh of meshOfLevelSet() at the nodes of the same lattice, with the sign that the level set has
/// there. They are exact for that mesh at any distance, where sweeping adds an error at each voxel.
/// @param band  half width, voxels, above 1
/// @return a level set in world units, flood filled
/// @throw DataError  as meshOfLevelSet(), or the voxels are not cubes
/// @throw std::invalid_argument  more than 2^31 nodes
/// @throw Interrupted
openvdb::FloatGrid::Ptr redistanced(const openvdb::FloatGrid& levelSet, double band, Monitor& monitor);

}  // namespace vdbtools
