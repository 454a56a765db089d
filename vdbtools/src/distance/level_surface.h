// SPDX-License-Identifier: Apache-2.0
/// @file level_surface.h
/// The surface on which a sampled field has a value.
#pragma once

#include "vdbtools/base/grids.h"

#include <vector>

namespace vdbtools {

struct LevelSurface {
  std::vector<openvdb::Vec3d> points;  ///< index space
  std::vector<openvdb::Vec3I> triangles;
};

/// By openvdb::tools::volumeToMesh. Points are in single precision, so the grid is best about the origin.
LevelSurface levelSurface(const openvdb::FloatGrid& grid, double isovalue);

}  // namespace vdbtools
