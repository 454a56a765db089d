// SPDX-License-Identifier: Apache-2.0
/// @file usd_job.h
/// VDBs and a mesh that were made before, as one scene of USD.
#pragma once

#include "vdbtools/base/monitor.h"

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

struct UsdOptions {
  std::string vdb;            ///< its name, with a pattern if there are frames; empty: none
  std::vector<int> frames{};  ///< their numbers, in any order; none: a single file
  std::optional<std::filesystem::path> mesh;
  std::filesystem::path scene;  ///< where the scene will be, to whose folder paths are relative
  double metersPerUnit = 1;
  double framesPerSecond = 24;
};

struct UsdCounts {
  std::size_t frames = 0, fields = 0, triangles = 0;
};

/// The scene has the up axis that the first VDB was written with; without one, that of the mesh. A mesh of another axis
/// is turned.
/// @throw std::invalid_argument  frames without a pattern, or a pattern without frames
/// @throw DataError              the frames have other grids than the first, or another up axis
/// @throw what reading the files throws
UsdCounts writeUsdScene(std::ostream& stream, const UsdOptions& options, Monitor& monitor);

}  // namespace vdbtools
