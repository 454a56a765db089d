// SPDX-License-Identifier: Apache-2.0
/// @file usd_file.h
/// The room `usd` writes scenes of USD. It uses the rooms up to `job`.
///
/// Scenes in the text form of USD (.usda, OpenUSD), as a side-car to what the program makes: a Volume whose fields are
/// the grids of VDB files, frame by frame, and a mesh. The volumes stay in their files, to which the scene refers. The
/// mesh is part of the scene, since USD itself refers to no mesh files but its own.
#pragma once

#include "vdbtools/base/up_axis.h"
#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// A grid, in the words of UsdVolOpenVDBAsset.
struct UsdField {
  std::string grid;        ///< its name in the VDB
  std::string dataType;    ///< "float", "int", "float3" and so on; empty: one that USD has no word for
  std::string fieldClass;  ///< "levelSet", "fogVolume", "staggered" or "unknown"

  bool operator==(const UsdField&) const = default;
};

struct UsdFrame {
  std::optional<int> number;  ///< none: the volume does not change
  std::filesystem::path vdb;  ///< relative to the scene's folder
  openvdb::BBoxd box;         ///< of the grids, world units
};

struct UsdScene {
  UpAxis up = UpAxis::Y;
  double metersPerUnit = 1;
  double framesPerSecond = 24;
  std::vector<UsdField> fields{};
  std::vector<UsdFrame> frames{};  ///< one without a number, or any number of them in rising order
  /// In the axes of the scene. Attributes red, green and blue become its colours, as linear light.
  const Mesh* mesh = nullptr;
};

/// The same scene gives the same bytes.
/// @throw std::invalid_argument  neither a frame nor a mesh; two fields whose names are the same as identifiers
void writeUsda(std::ostream& stream, const UsdScene& scene);

}  // namespace vdbtools
