// SPDX-License-Identifier: Apache-2.0
/// @file island_choice.h
/// Chooses the islands to keep, by the same rule for one field and for islands joined from tiles.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/field/islands.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace vdbtools {

/// An island, or a part of one.
struct Island {
  std::uint64_t nodes = 0;
  openvdb::CoordBBox box;
  openvdb::Coord first = openvdb::Coord::max();  ///< in the order of (x, y, z)
  bool isKept = true;

  void add(const Island& other) {
    nodes += other.nodes;
    box.expand(other.box);
    first = std::min(first, other.first);
  }
  void addBox(const openvdb::CoordBBox& other) {
    nodes += other.volume();
    box.expand(other);
    first = std::min(first, other.min());
  }
};

/// Clears Island::kept for the islands that are to be dropped.
/// @param voxelSize  world units
/// @throw DataError  no island is as large as minSize (Remedy::SmallerIslands)
IslandReport chooseIslands(const std::vector<Island*>& islands, const IslandOptions& options, double voxelSize);

}  // namespace vdbtools
