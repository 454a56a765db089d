// SPDX-License-Identifier: Apache-2.0
/// @file recorded_recipe.h
/// The room `records` finds what a file of the program records: its recipe, and where that recipe's files are now. It
/// uses the rooms up to `job`.
///
/// This header reads the recipes in files that the program made.
#pragma once

#include "vdbtools/files/input_files.h"
#include "vdbtools/maps/map_registry.h"
#include "vdbtools/recipe/recipe.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

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
/// sheet_job.h), and checks that its options are valid. Only a recipe file may lack a target, for the caller to give.
/// @throw DataError  an entry is broken; MissingInputError, IoError
/// @throw std::invalid_argument  there is no such cell
RecordedRecipe readRecordedRecipe(const std::filesystem::path& path, const MapRegistry& maps = builtInMaps());

/// The camera and the light of a cell of a contact sheet, as options of pictureOptionSpecs(), checked. Empty for any
/// other file, and for sheets that do not record them.
/// @throw as readRecordedRecipe()
Recipe readRecordedView(const std::filesystem::path& path);

// Finds the files of a recorded recipe where they are today. A recipe has their names as they were typed, which are
// meaningful only in the working folder of that time; their SHA-256 identifies them wherever they are.

struct FileSearch {
  std::filesystem::path holder;                ///< the file that contains the recipe, or the name of a cell of a sheet
  std::vector<std::filesystem::path> folders;  ///< further folders to search
  std::string wayOut;  ///< what else the user can do, as the end of the error message: ", or ..."
};

struct FoundFiles {
  struct Entry {
    std::filesystem::path recorded, found;
  };
  Recipe recipe;                 ///< names the files where they were found, so that they can be opened
  std::vector<Entry> elsewhere;  ///< the files that were not found under their recorded names
};

/// Finds each file whose SHA-256 the recipe has, and accepts only a file with that hash. It looks under the recorded
/// name, from the working folder and from the holder's folder; then for a file of that name in the holder's folder and
/// in the given folders; and finally, by its hash alone, for any file with the same extension in or below the given
/// folders. A file that exists under its recorded name with other content, and is not found elsewhere, keeps its name,
/// and is refused when it is opened.
/// @param recipe  the recipe of a fractal
/// @throw MissingInputError      a file was not found
/// @throw std::invalid_argument  an option is refused, a folder to search is not a folder, or a file was found under a
///                               name that cannot be written in a recipe
FoundFiles findRecordedFiles(const Recipe& recipe, const FileSearch& search, const MapRegistry& maps = builtInMaps());

/// Adds to @a inputs the files that the recipes in them name, and those that the recipes in these files name, so that
/// no output replaces the target of a fractal, even if only the fractal's voxels are read. For each recorded name, all
/// files at the places where findRecordedFiles() would look without folders are added, without checking their hashes.
/// Inputs that cannot be read, or whose recipe is broken, are skipped here; the code that reads them reports the error.
InputFiles withRecordedFiles(InputFiles inputs, const MapRegistry& maps = builtInMaps());

}  // namespace vdbtools
