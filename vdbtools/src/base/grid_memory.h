// SPDX-License-Identifier: Apache-2.0
/// @file grid_memory.h
/// Limits on the memory that grids of files may take: a few bytes of a file can stand for a box of any size.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Call before creating leaves that @a grid requires.
/// @throw DataError  they would take more than half of the machine's memory; there is always more than one grid
void requireRoomForLeaves(const openvdb::FloatGrid& grid, double leaves);

/// Converts the active tiles of a loaded grid to leaves.
/// @throw DataError  as requireRoomForLeaves()
/// @throw MemoryError  they take more memory than is left
void voxelizeActiveTiles(openvdb::FloatGrid& grid);

}  // namespace vdbtools
