// SPDX-License-Identifier: Apache-2.0
/// @file recorded_recipe.h
/// The room `records` finds what a file of the program records: its recipe, and where that recipe's files are now. It
/// uses the rooms up to `job`.
///
/// This header reads the recipes in files that the program made.
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

/// The recipe in metadata, unchanged.
RecordedRecipe recordedRecipe(const std::map<std::string, std::string>& metadata,
                              const MapRegistry& maps = builtInMaps());

/// Whether a file is a recipe by itself, as encodeRecipe() makes it. Its name has to end in .json.
bool isRecipeFile(const std::filesystem::path& path);

/// The error message for a file without a recipe.
std::string noRecipeText(const std::filesystem::path& path);

/// Encodes a recipe as a file of its own: JSON with the command, and each entry as text.
std::string encodeRecipe(const RecordedRecipe& recorded);

/// Reads the recipe from a VDB, PLY, OBJ or GLB, a recipe file, or a cell of a contact sheet ("sheet.json#7", see
/// sheet_file.h), and checks that its options are valid.
/// @throw DataError  an entry is broken; MissingInputError, IoError
/// @throw std::invalid_argument  there is no such cell
RecordedRecipe readRecordedRecipe(const std::filesystem::path& path, const MapRegistry& maps = builtInMaps());

/// The camera and the light of a cell of a contact sheet, as options of pictureOptionSpecs(), checked. Empty for any
/// other file, and for sheets that do not record them.
/// @throw as readRecordedRecipe()
Recipe readRecordedView(const std::filesystem::path& path);

}  // namespace vdbtools
