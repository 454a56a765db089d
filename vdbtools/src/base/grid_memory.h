// SPDX-License-Identifier: Apache-2.0
/// @file grid_memory.h
/// What grids of files may take of memory: a few bytes of a file can stand for a box of any size.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Before leaves are made that @a grid asks for.
/// @throw DataError  they would take more than half of the machine's memory: there is always more than one grid
void requireRoomForLeaves(const openvdb::FloatGrid& grid, double leaves);

/// Makes leaves of the active tiles of a grid that was read.
/// @throw DataError  as requireRoomForLeaves()
/// @throw MemoryError  there is less memory left than they take
void voxelizeActiveTiles(openvdb::FloatGrid& grid);

}  // namespace vdbtools
