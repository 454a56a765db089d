// SPDX-License-Identifier: Apache-2.0
/// @file usd_file.h
/// The room `usd` writes USD scenes. It uses the rooms up to `job`.
///
/// This header writes scenes in the text form of USD (.usda, OpenUSD), as a side-car to the program's outputs: a Volume
/// whose fields are the grids of VDB files, frame by frame, and a mesh. The scene refers to the VDB files. It contains
/// the mesh itself, because USD cannot refer to mesh files other than its own.
#pragma once

#include "vdbtools/base/up_axis.h"
#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// A grid, in the terms of UsdVolOpenVDBAsset.
struct UsdField {
  std::string grid;        ///< its name in the VDB
  std::string dataType;    ///< "float", "int", "float3" and so on; empty: USD has no token for it
  std::string fieldClass;  ///< "levelSet", "fogVolume", "staggered" or "unknown"

  bool operator==(const UsdField&) const = default;
};

struct UsdFrame {
  std::optional<int> number;  ///< empty: the volume does not change
  std::filesystem::path vdb;  ///< relative to the scene's folder
  openvdb::BBoxd box;         ///< bounds of the grids, world units
};

struct UsdScene {
  UpAxis up = UpAxis::Y;
  double metersPerUnit = 1;
  double framesPerSecond = 24;
  std::vector<UsdField> fields{};
  std::vector<UsdFrame> frames{};  ///< one without a number, or any number of them in ascending order
  /// In the axes of the scene. Its attributes red, green and blue become its colours, as linear light.
  const Mesh* mesh = nullptr;
};

/// Writes a scene. The same scene gives the same bytes.
/// @throw std::invalid_argument  neither a frame nor a mesh; two fields whose names become the same identifier
void writeUsda(std::ostream& stream, const UsdScene& scene);

}  // namespace vdbtools
