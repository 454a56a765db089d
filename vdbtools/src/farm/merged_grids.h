// SPDX-License-Identifier: Apache-2.0
/// @file merged_grids.h
/// What merging a plan makes of the grids of its tiles.
#pragma once

#include "farm/merged_mesh.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/merge.h"
#include "vdbtools/formats/vdb_file.h"

#include <filesystem>
#include <vector>

namespace vdbtools::farm {

/// The grid of a tile's file that has this name; null if there is none.
openvdb::FloatGrid::Ptr partNamed(const VdbFile& file, const char* name);

/// Merges the grids of all tiles into the grids that a single run would make.
/// @param islands, attributes  may be null
/// @param result  gets the number of voxels in the level set's band, and its check
/// @throw DataError  no tile has a part of the level set
std::vector<openvdb::GridBase::Ptr> mergeGrids(const std::filesystem::path& folder, const TileJob& job,
                                               const PlanIslands* islands, const PlanAttributes* attributes,
                                               MergeResult& result, Monitor& monitor);

}  // namespace vdbtools::farm
