// SPDX-License-Identifier: Apache-2.0
#include "base/grid_memory.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"

namespace vdbtools {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

constexpr double kLeafBytes = Leaf::SIZE * sizeof(float) + sizeof(Leaf);

}  // namespace

void requireRoomForLeaves(const openvdb::FloatGrid& grid, double leaves) {
  const double needed = leaves * kLeafBytes, memory = machineMemory();
  if (needed > memory / 2)
    throw DataError("the grid '" + grid.getName() + "' would take " + memoryText(needed) +
                    " where all its voxels are needed; this machine has a memory of " + memoryText(memory));
}

void voxelizeActiveTiles(openvdb::FloatGrid& grid) {
  const auto inTiles = static_cast<double>(grid.tree().activeVoxelCount() - grid.tree().activeLeafVoxelCount());
  const double leaves = inTiles / Leaf::SIZE;
  requireRoomForLeaves(grid, leaves);
  requireMemory(leaves * kLeafBytes, MemoryUse::File, "the grid '" + grid.getName() + "' with the voxels of its tiles");
  grid.tree().voxelizeActiveTiles();
}

}  // namespace vdbtools
