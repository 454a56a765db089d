// SPDX-License-Identifier: Apache-2.0
/// @file direction_grids.h
/// Reads directions from a VDB, in the forms in which artists make them: a grid of vectors, or three or four grids of
/// floats.
#pragma once

#include "vdbtools/base/grids.h"

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools {

struct DirectionGrids {
  std::vector<openvdb::FloatGrid::Ptr> components;  ///< three or four, on one lattice
  std::string name;                                 ///< for errors: "'v' of 'wind.vdb'"
  /// A point outside these nodes gets the direction of the nearest of them.
  openvdb::CoordBBox nodes{};
};

/// @param names   a grid of vectors, or three or four float grids; empty: the only grid of vectors
/// @param option  for errors: "--texture"
/// @throw MissingInputError, DataError, IoError  as readVdb()
/// @throw DataError  no such grids, grids of another type or on different lattices, a value that is not finite
DirectionGrids readDirectionGrids(const std::filesystem::path& path, const std::vector<std::string>& names,
                                  const std::string& option);

/// Extends the grids so that there is a direction wherever a target reads them: nodes about the target that have none
/// get smooth means of those that have one. Given directions stay unchanged.
/// @param box  of the target, world units
/// @throw DataError    no direction near the target, or a cell of eight nodes there that are all 0
/// the nodes would take more memory than is left
DirectionGrids filledAbout(const DirectionGrids& grids, const openvdb::BBoxd& box, const std::string& option);

}  // namespace vdbtools
