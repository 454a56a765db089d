// SPDX-License-Identifier: Apache-2.0
/// @file open_shapes.h
/// Solids from what bounds none: terrain, sheets, clouds of points.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/repair/mend_options.h"

namespace vdbtools {

/// The block below an open mesh: walls from each of its open edges straight down to a plane, and a base there. Where no
/// part of the mesh overhangs, the base is the mesh laid flat, so that holes of the mesh become shafts; otherwise each
/// loop of open edges has a base of its own. Oriented outward where the mesh is oriented consistently.
/// @param repair  caps all holes first
/// @throw DataError  the mesh has no open edge, or no extent across the axis
Mesh solidified(const Mesh& mesh, const SolidifyOptions& options, bool repair);

/// The surface at a distance from the mesh. It is found on a lattice whose voxels are no larger than @a voxelSize and
/// half the distance, though not below a sixteenth of @a voxelSize; its error is a small share of its voxel.
/// @param mesh  its triangles may be points
/// @throw std::invalid_argument  more nodes than a lattice may have
/// @throw DataError              nothing is left on that lattice
/// @throw Interrupted
Mesh offsetSurface(const Mesh& mesh, double distance, double voxelSize, Monitor& monitor);

}  // namespace vdbtools
