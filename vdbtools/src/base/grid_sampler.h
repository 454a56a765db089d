// SPDX-License-Identifier: Apache-2.0
/// @file grid_sampler.h
/// OpenVDB grids in the form that the dynamics reads fastest (docs/performance.md has the comparison).
#pragma once

#include "julia/brick_field.h"
#include "vdbtools/base/grids.h"

namespace vdbtools {

/// A copy of a grid's values as bricks, with their placement. Bricks are aligned with the grid's leaves. All bricks
/// with a single constant value share their storage if the value is the same.
struct GridBricks {
  std::shared_ptr<const julia::Bricks> bricks;
  openvdb::Coord origin;     ///< index of the first brick's first own node
  openvdb::CoordBBox nodes;  ///< index space; points outside get the value of the nearest of these nodes
};

/// @param nodes  the nodes to copy; not empty
/// @throw std::invalid_argument  the number of bricks exceeds 32 bits
GridBricks makeBricks(const openvdb::FloatGrid& grid, const openvdb::CoordBBox& nodes,
                      julia::Interpolation interpolation);

}  // namespace vdbtools
