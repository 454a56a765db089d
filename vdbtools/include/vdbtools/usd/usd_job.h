// SPDX-License-Identifier: Apache-2.0
/// @file usd_job.h
/// Combines existing VDBs and meshes, also those of the frames of a sequence, into one USD scene.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/base/units.h"

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

struct UsdOptions {
  std::string vdb;              ///< the name of the VDB, which may contain a frame pattern; empty: none
  std::string mesh;             ///< the same for the mesh
  std::vector<int> frames{};    ///< frame numbers, in any order; empty: no sequence. A name without a frame pattern is
                                ///< one file for all frames
  std::filesystem::path scene;  ///< where the scene will be; the paths of VDBs are relative to its folder
  /// The unit of files that do not record one; if empty, it is unknown.
  std::optional<LengthUnit> unit{};
  /// Metres per unit of the scene. If empty, it follows from the unit; without a unit it is 1.
  std::optional<double> metersPerUnit{};
  double framesPerSecond = 24;
};

/// Where the scene is written: to one of these streams, or to both.
struct UsdOutputs {
  std::ostream* scene = nullptr;
  std::ostream* package = nullptr;  ///< receives it as a package (usd_package.h)
  std::string packageName;          ///< the scene's file name in the package
};

struct UsdCounts {
  std::size_t frames = 0;  ///< number of VDBs
  std::size_t fields = 0;
  std::size_t meshes = 0;
  std::size_t triangles = 0;  ///< the total of all meshes
};

/// Writes the scene. Its up axis and its unit are those of the first VDB or, without a VDB, of the first mesh. Meshes
/// with another up axis are rotated, and meshes that record another unit are scaled.
/// @throw std::invalid_argument  a frame pattern without frames, or a file that records another unit than the options
///                               name
/// @throw DataError              frames differ from the first one in their grids, their up axis or their unit; only
///                               some of the meshes have colours; or a mesh has changed since it was first read
/// @throw what reading the files throws, and writeUsdPackage()
UsdCounts writeUsdScene(const UsdOutputs& outputs, const UsdOptions& options, Monitor& monitor);

}  // namespace vdbtools
