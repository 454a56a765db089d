// SPDX-License-Identifier: Apache-2.0
/// @file usd_job.h
/// Combines existing VDBs and a mesh into one USD scene.
#pragma once

#include "vdbtools/base/length_unit.h"
#include "vdbtools/base/monitor.h"

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

struct UsdOptions {
  std::string vdb;            ///< name of the VDB, with a pattern if there are frames; empty: none
  std::vector<int> frames{};  ///< frame numbers, in any order; none: a single file
  std::optional<std::filesystem::path> mesh;
  std::filesystem::path scene;  ///< where the scene will be; paths are relative to its folder
  /// The unit of the files that do not name theirs; none: nobody has said.
  std::optional<LengthUnit> unit{};
  /// The length of a unit of the scene, where it is said by a number; none: that of the unit, or 1 without one.
  std::optional<double> metersPerUnit{};
  double framesPerSecond = 24;
};

struct UsdCounts {
  std::size_t frames = 0, fields = 0, triangles = 0;
};

/// Writes the scene. It has the up axis and the unit of the first VDB; without a VDB, those of the mesh. A mesh with
/// another up axis is rotated, and one that names another unit is scaled.
/// @throw std::invalid_argument  frames without a pattern, or a pattern without frames
/// @throw std::invalid_argument  a file names another unit than the options do
/// @throw DataError              the grids, the up axis or the unit of the frames differ from those of the first
/// @throw what reading the files throws
UsdCounts writeUsdScene(std::ostream& stream, const UsdOptions& options, Monitor& monitor);

}  // namespace vdbtools
