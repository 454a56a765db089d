// SPDX-License-Identifier: Apache-2.0
/// @file grid_formats.h
/// The formats of grids: the table in which each is a row with the functions that write it. A new format is a source
/// with its functions, and their declarations and a row here.
#pragma once

#include "formats/vdb_head.h"
#include "vdbtools/files/file_format.h"
#include "vdbtools/formats/file_formats.h"

#include <array>
#include <filesystem>
#include <iosfwd>
#include <string_view>
#include <vector>

namespace vdbtools {

using GridWriter = std::vector<NvdbWritten>(std::ostream& stream, const std::vector<openvdb::GridBase::Ptr>& grids,
                                            const VdbWriteOptions& options, NvdbValues values);

GridWriter writeVdbGrids, writeNvdbGrids;

struct GridFormat {
  FileFormat facts;
  GridWriter* write = nullptr;
  // The texts of a file, and of the beginning of one; null where the format has no room for any.
  FileTexts (*texts)(const std::filesystem::path& path) = nullptr;
  FileTexts (*textsOfHead)(std::string_view bytes) = nullptr;
};

// clang-format off
inline constexpr auto kGridFormats = std::to_array<GridFormat>({
    {.facts = {.extension = ".vdb", .name = "VDB", .readsGrids = true, .writesGrids = true, .points = true,
               .recipe = true, .unit = true, .columns = FormatColumns::OfVoxels, .half = true},
     .write = writeVdbGrids, .texts = readVdbMetadata, .textsOfHead = vdbHeadMetadata},
    {.facts = {.extension = ".nvdb", .name = "NanoVDB", .writesGrids = true, .isBuilt = canWriteNvdb,
               .columns = FormatColumns::OfVoxels, .nvdbBits = true},
     .write = writeNvdbGrids},
});
// clang-format on

}  // namespace vdbtools
