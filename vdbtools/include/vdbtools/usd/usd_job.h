// SPDX-License-Identifier: Apache-2.0
/// @file usd_job.h
/// Combines existing VDBs and meshes, also those of the frames of a sequence, into one USD scene.
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
  std::string vdb;              ///< the name of the VDB, perhaps with a place for the frame; empty: none
  std::string mesh;             ///< likewise of the mesh
  std::vector<int> frames{};    ///< frame numbers, in any order; none: no sequence. A name without a place for the
                                ///< frame is one file for all of them
  std::filesystem::path scene;  ///< where the scene will be; the paths of VDBs are relative to its folder
  /// The unit of the files that do not name theirs; none: nobody has said.
  std::optional<LengthUnit> unit{};
  /// The length of a unit of the scene, where it is said by a number; none: that of the unit, or 1 without one.
  std::optional<double> metersPerUnit{};
  double framesPerSecond = 24;
};

/// Where the scene goes: to one of these, or to both.
struct UsdOutputs {
  std::ostream* scene = nullptr;
  std::ostream* package = nullptr;  ///< as a package (usd_package.h)
  std::string packageName;          ///< what the scene is called in the package
};

struct UsdCounts {
  std::size_t frames = 0;  ///< VDBs
  std::size_t fields = 0;
  std::size_t meshes = 0;
  std::size_t triangles = 0;  ///< of all meshes
};

/// Writes the scene. It has the up axis and the unit of the first VDB; without a VDB, those of the first mesh. Meshes
/// with another up axis are rotated, and those that name another unit are scaled.
/// @throw std::invalid_argument  a pattern without frames, or a file names another unit than the options do
/// @throw DataError              the grids, the up axis or the unit of the frames differ from those of the first, some
///                               of the meshes have no colours, or a mesh has changed since it was read first
/// @throw what reading the files throws, and writeUsdPackage()
UsdCounts writeUsdScene(const UsdOutputs& outputs, const UsdOptions& options, Monitor& monitor);

}  // namespace vdbtools
