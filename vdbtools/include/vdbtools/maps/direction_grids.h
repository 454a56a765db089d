// SPDX-License-Identifier: Apache-2.0
/// @file direction_grids.h
/// Directions that a VDB holds, as artists make them: a grid of vectors, or three or four grids of floats.
#pragma once

#include "vdbtools/base/grids.h"

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools {

struct DirectionGrids {
  std::vector<openvdb::FloatGrid::Ptr> components;  ///< three or four, on one lattice
  std::string name;                                 ///< for errors: "'v' of 'wind.vdb'"
  /// Beyond these nodes the nearest of them counts.
  openvdb::CoordBBox nodes{};
};

/// @param names   a grid of vectors, or three or four float grids; empty: the only grid of vectors
/// @param option  for errors: "--texture"
/// @throw MissingInputError, DataError, IoError  as readVdb()
/// @throw DataError  no such grids, grids of another type or on different lattices, a value that is not finite
DirectionGrids readDirectionGrids(const std::filesystem::path& path, const std::vector<std::string>& names,
                                  const std::string& option);

/// The grids with a direction wherever a target reads them: where they are sparse, the nodes about the target that have
/// none get smooth means of those that have. What is given stays as it is.
/// @param box  of the target, world units
/// @throw DataError    no direction near the target, or a cell of eight nodes there that are all 0
/// @throw MemoryError  more nodes than there is memory for
DirectionGrids filledAbout(const DirectionGrids& grids, const openvdb::BBoxd& box, const std::string& option);

}  // namespace vdbtools
