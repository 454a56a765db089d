// SPDX-License-Identifier: Apache-2.0
/// @file recorded_recipe.h
/// The room `records` finds what a file of the program records: its recipe, and where that recipe's files are now. It
/// uses the rooms up to `job`.
///
/// The recipes in files that the program made.
#pragma once

#include "vdbtools/maps/map_registry.h"
#include "vdbtools/recipe/recipe.h"

#include <filesystem>
#include <map>
#include <string>

namespace vdbtools {

struct RecordedRecipe {
  std::string command;  ///< "fractal" or "sdf"; empty: the file holds no recipe
  Recipe recipe;
};

/// What metadata say, as it stands there.
RecordedRecipe recordedRecipe(const std::map<std::string, std::string>& metadata,
                              const MapRegistry& maps = builtInMaps());

/// Whether a file is a recipe by itself, as encodeRecipe() makes it. The name has to end in .json.
bool isRecipeFile(const std::filesystem::path& path);

/// What is wrong with a file in which there is no recipe.
std::string noRecipeText(const std::filesystem::path& path);

/// A recipe as a file of its own: JSON with the command, and each entry as a text.
std::string encodeRecipe(const RecordedRecipe& recorded);

/// The same of a VDB, PLY, OBJ or GLB, of a recipe file, or of a cell of a contact sheet ("sheet.json#7", see
/// sheet_file.h), checked: its options can be used.
/// @throw DataError  an entry is broken; MissingInputError, IoError
/// @throw std::invalid_argument  there is no such cell
RecordedRecipe readRecordedRecipe(const std::filesystem::path& path, const MapRegistry& maps = builtInMaps());

/// Where a cell of a contact sheet is seen from and in which light, by pictureOptionSpecs(), checked. Empty for any
/// other file, and for sheets that do not say it.
/// @throw as readRecordedRecipe()
Recipe readRecordedView(const std::filesystem::path& path);

}  // namespace vdbtools
