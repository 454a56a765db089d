// SPDX-License-Identifier: Apache-2.0
#include "base/grid_memory.h"

#include "vdbtools/base/errors.h"

#include <unistd.h>

#include <cmath>
#include <limits>

namespace vdbtools {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

}  // namespace

std::uint64_t machineMemory() {
  const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(size);
}

void requireRoomForLeaves(const openvdb::FloatGrid& grid, double leaves) {
  constexpr double kLeafBytes = Leaf::SIZE * sizeof(float) + sizeof(Leaf), kGigabyte = 1e9;
  const double needed = leaves * kLeafBytes, memory = static_cast<double>(machineMemory());
  if (needed > memory / 2)
    throw DataError("the grid '" + grid.getName() + "' would take " + std::to_string(std::llround(needed / kGigabyte)) +
                    " GB where all its voxels are needed; this " + "machine has a memory of " +
                    std::to_string(std::llround(memory / kGigabyte)) + " GB");
}

void voxelizeActiveTiles(openvdb::FloatGrid& grid) {
  const auto inTiles = static_cast<double>(grid.tree().activeVoxelCount() - grid.tree().activeLeafVoxelCount());
  requireRoomForLeaves(grid, inTiles / Leaf::SIZE);
  grid.tree().voxelizeActiveTiles();
}

}  // namespace vdbtools
