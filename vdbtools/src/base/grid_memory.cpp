// SPDX-License-Identifier: Apache-2.0
#include "base/grid_memory.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"

namespace vdbtools {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

}  // namespace

void requireRoomForLeaves(const openvdb::FloatGrid& grid, double leaves) {
  constexpr double kLeafBytes = Leaf::SIZE * sizeof(float) + sizeof(Leaf);
  const double needed = leaves * kLeafBytes, memory = machineMemory();
  if (needed > memory / 2)
    throw DataError("the grid '" + grid.getName() + "' would take " + memoryText(needed) +
                    " where all its voxels are needed; this machine has a memory of " + memoryText(memory));
}

void voxelizeActiveTiles(openvdb::FloatGrid& grid) {
  const auto inTiles = static_cast<double>(grid.tree().activeVoxelCount() - grid.tree().activeLeafVoxelCount());
  requireRoomForLeaves(grid, inTiles / Leaf::SIZE);
  grid.tree().voxelizeActiveTiles();
}

}  // namespace vdbtools
