// SPDX-License-Identifier: Apache-2.0
/// @file file_axes.h
/// The axis that points up in the target and in the files that are made from it, and the unit of their coordinates.
#pragma once

#include "vdbtools/base/units.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// The metadata entry that names the axis which points up in a file, "y" or "z".
inline constexpr const char* kUpAxis = "julia_up_axis";

enum class UpRule {
  Keep,  ///< as in the target, except in GLB, whose specification has Y up
  Y,
  Z,
  Auto,  ///< as most readers of the format assume: Z up in PLY and STL, Y up in all others
};

struct FileAxes {
  UpAxis target = UpAxis::Y;  ///< of the target's own coordinates, in which the fractal is made
  UpRule rule = UpRule::Keep;
  std::optional<LengthUnit> unit{};  ///< of the target's coordinates, if --units gives it

  UpAxis of(const FileFormat& format) const;
  UpAxis ofVdb() const;
};

/// --target-up, --up and --units.
std::vector<OptionSpec> fileAxesOptionSpecs();
/// @throw std::invalid_argument naming the option and the value
FileAxes parseFileAxes(const RecipeReader& reader);
/// The value of --up. @throw std::invalid_argument
UpRule parseUpRule(const std::string& value);

/// The value of --units. @throw std::invalid_argument
LengthUnit parseLengthUnit(const std::string& value);

/// The axis that metadata name; @a otherwise if they name none.
/// @throw DataError  the entry is neither "y" nor "z"
UpAxis recordedUpAxis(const std::map<std::string, std::string>& metadata, UpAxis otherwise = UpAxis::Y);

/// The unit that metadata name, if they name one. @throw DataError  the entry is no unit
std::optional<LengthUnit> recordedUnit(const std::map<std::string, std::string>& metadata);
/// The unit of the target: the requested one, or else the one in its metadata.
std::optional<LengthUnit> unitOfTarget(const FileAxes& axes, const std::map<std::string, std::string>& metadata);
/// The unit that a VDB or a mesh of this program records. Empty for other files, which do not record their unit in this
/// way.
/// @throw what reading the beginning of the file throws
std::optional<LengthUnit> unitOfFile(const std::filesystem::path& path);
/// The unit of a file's coordinates: the one that it records, or else the requested one.
/// @throw std::invalid_argument  the two differ
std::optional<LengthUnit> agreedUnit(std::optional<LengthUnit> asked, std::optional<LengthUnit> recorded,
                                     const std::filesystem::path& path);

/// Records the unit in a mesh file; a GLB is also scaled to metres. @param unit  of the mesh
void setUnit(MeshWriteOptions& options, LengthUnit unit);

/// The options that convert a file's content from the target's coordinates to those of the file. Its metadata are the
/// given ones, and the axis and the unit. The unit of the target is that of the axes, or else that of the metadata. If
/// neither has one, none is recorded. If there is one, a GLB is scaled to metres, and all other files keep the
/// coordinates.
VdbWriteOptions vdbWriteOptions(const FileAxes& axes, std::map<std::string, std::string> metadata);
MeshWriteOptions meshWriteOptions(const FileFormat& format, const FileAxes& axes,
                                  std::map<std::string, std::string> metadata);

}  // namespace vdbtools
