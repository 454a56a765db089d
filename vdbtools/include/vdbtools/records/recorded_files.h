// SPDX-License-Identifier: Apache-2.0
/// @file recorded_files.h
/// Where the files of a recorded recipe are today. A recipe has their names as they were typed, which mean something
/// only in the folder of that time; their SHA-256 tells whether a file of the same name elsewhere is the same.
#pragma once

#include "vdbtools/files/input_files.h"
#include "vdbtools/maps/map_registry.h"
#include "vdbtools/recipe/recipe.h"

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools {

struct FileSearch {
  std::filesystem::path holder;                ///< the file that has the recipe; a cell of a sheet is one, too
  std::vector<std::filesystem::path> folders;  ///< to look in besides
  std::string wayOut;                          ///< what else the user can do, for the error: ", or ..."
};

struct FoundFiles {
  struct Entry {
    std::filesystem::path recorded, found;
  };
  Recipe recipe;                 ///< with the names under which the files are found, for opening them
  std::vector<Entry> elsewhere;  ///< those that are not where the recipe says
};

/// Looks for each file of which the recipe has the SHA-256, and takes only a file that has it: where the recipe says,
/// from the working folder and from the holder's; then a file of that name in the holder's folder and in @a folders;
/// and then, by its hash alone, any file in @a folders, or below, with the same extension. A file that is where the
/// recipe says but has changed, and is not found elsewhere, keeps its name: who opens it refuses it.
/// @param recipe  of a fractal
/// @throw MissingInputError      a file is nowhere
/// @throw std::invalid_argument  an option is refused, one of the folders is none, or a file was found under a name
///                               that cannot stand in the recipe
FoundFiles findRecordedFiles(const Recipe& recipe, const FileSearch& search, const MapRegistry& maps = builtInMaps());

/// With the files that the recipes in @a inputs name, and those that the recipes in these name: whoever reads only the
/// voxels of a fractal still has its target. Of each, every file that findRecordedFiles() would look at without
/// folders; their hashes are not asked for. An input that cannot be read, or whose recipe is broken, is left to its
/// readers.
InputFiles withRecordedFiles(InputFiles inputs, const MapRegistry& maps = builtInMaps());

}  // namespace vdbtools
