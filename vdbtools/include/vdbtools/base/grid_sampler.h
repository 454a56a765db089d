// SPDX-License-Identifier: Apache-2.0
/// @file grid_sampler.h
/// OpenVDB grids in the form in which the dynamics reads them fastest (docs/performance.md has the comparison).
#pragma once

#include "julia/brick_field.h"
#include "vdbtools/base/grids.h"

namespace vdbtools {

/// A copy of a grid's values as bricks, and where they lie. Bricks are aligned with the grid's leaves, and bricks of
/// one value are shared.
struct GridBricks {
  std::shared_ptr<const julia::Bricks> bricks;
  openvdb::Coord origin;     ///< index of the first brick's first own node
  openvdb::CoordBBox nodes;  ///< index space; beyond these the nearest of their values holds
};

/// @param nodes  which of the grid's nodes; not empty
/// @throw std::invalid_argument  more bricks than 32 bits count
GridBricks makeBricks(const openvdb::FloatGrid& grid, const openvdb::CoordBBox& nodes,
                      julia::Interpolation interpolation);

}  // namespace vdbtools
