// SPDX-License-Identifier: Apache-2.0
/// @file open_shapes.h
/// Makes solids from terrain, sheets and point clouds.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/repair/mend_options.h"

namespace vdbtools {

/// Makes the block below an open mesh: walls from each of its open edges straight down to a plane, and a base there. If
/// no part of the mesh overhangs, the base is the mesh projected to the plane, so that holes of the mesh become shafts;
/// otherwise each loop of open edges has its own base. The result is oriented outward if the mesh is oriented
/// consistently.
/// @param repair  caps all holes first
/// @throw DataError  the mesh has no open edge, or no extent across the axis
Mesh solidified(const Mesh& mesh, const SolidifyOptions& options, bool repair);

/// Computes the surface at a distance from the mesh. It uses a lattice whose voxels are no larger than @a voxelSize and
/// half the distance, but not below a sixteenth of @a voxelSize; the error is a small fraction of its voxel.
/// @param mesh  its triangles may be points
/// @throw std::invalid_argument  the lattice would have too many nodes
/// @throw DataError              nothing is left on that lattice
/// @throw Interrupted
Mesh offsetSurface(const Mesh& mesh, double distance, double voxelSize, Monitor& monitor);

}  // namespace vdbtools
