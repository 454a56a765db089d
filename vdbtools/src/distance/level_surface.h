// SPDX-License-Identifier: Apache-2.0
/// @file level_surface.h
/// An isosurface of a sampled field.
#pragma once

#include "vdbtools/base/grids.h"

#include <vector>

namespace vdbtools {

struct LevelSurface {
  std::vector<openvdb::Vec3d> points;  ///< index space
  std::vector<openvdb::Vec3I> triangles;
};

/// Uses openvdb::tools::volumeToMesh. Points are in single precision, so the grid should lie around the origin.
LevelSurface levelSurface(const openvdb::FloatGrid& grid, double isovalue);

}  // namespace vdbtools
