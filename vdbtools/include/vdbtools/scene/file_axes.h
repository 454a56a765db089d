// SPDX-License-Identifier: Apache-2.0
/// @file file_axes.h
/// Which axis points up in the target, and in the files that are made of it.
#pragma once

#include "vdbtools/base/up_axis.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <map>
#include <string>
#include <vector>

namespace vdbtools {

/// The metadata that names the axis which points up in a file, "y" or "z".
inline constexpr const char* kUpAxis = "julia_up_axis";

enum class UpRule {
  Keep,  ///< as in the target, except in GLB, whose specification has Y up
  Y,
  Z,
  Auto,  ///< as most readers of the format take it without being told: PLY and STL have Z up, all others Y
};

struct FileAxes {
  UpAxis target = UpAxis::Y;  ///< of the target's own coordinates, in which the fractal is made
  UpRule rule = UpRule::Keep;

  UpAxis ofVdb() const;
  UpAxis ofMesh(MeshFormat format) const;
};

/// --target-up and --up.
std::vector<OptionSpec> fileAxesOptionSpecs();
/// @throw std::invalid_argument naming the option and the value
FileAxes parseFileAxes(const RecipeReader& reader);
/// The value of --up. @throw std::invalid_argument
UpRule parseUpRule(const std::string& value);

/// The axis that metadata name; @a otherwise if they name none.
/// @throw DataError  the entry is neither "y" nor "z"
UpAxis recordedUpAxis(const std::map<std::string, std::string>& metadata, UpAxis otherwise = UpAxis::Y);

/// What turns a file's content from the target's coordinates to its own, with the metadata and the axis as one of them.
VdbWriteOptions vdbWriteOptions(const FileAxes& axes, std::map<std::string, std::string> metadata);
MeshWriteOptions meshWriteOptions(MeshFormat format, const FileAxes& axes, std::map<std::string, std::string> metadata);

}  // namespace vdbtools
