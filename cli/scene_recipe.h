// SPDX-License-Identifier: Apache-2.0
/// @file scene_recipe.h
/// The recipe of a command that takes one from a file that the program made, and where the files that it names are now.
#pragma once

#include "options.h"

#include <filesystem>
#include <string>

namespace cli {

/// Adds --search, for commands that take a recipe from a generated file.
void addSearchOption(CommandLine& line);
/// Returns a fractal's recipe with its files at their current paths, for opening them. It follows --search and prints a
/// note for each file that has moved (vdbtools/records/recorded_recipe.h). Recorded recipes keep their original names.
/// @param holder  the file that holds the recipe; empty: it was typed, and stays unchanged
/// @param wayOut  what else the user can do if a file is missing
/// @throw as vdbtools::findRecordedFiles()
vdbtools::Recipe withFoundFiles(const CommandLine& line, const vdbtools::Recipe& recipe,
                                const std::filesystem::path& holder, const std::string& wayOut = {});

/// Returns the given recipe of a command that shows a scene. If the input is a fractal that this program made, its own
/// recipe supplies the options that were not given, including its input. Its files are named at their current paths, by
/// withFoundFiles().
vdbtools::Recipe givenSceneRecipe(const CommandLine& line, const std::string& input);
/// As givenSceneRecipe(), but completed.
vdbtools::Recipe sceneRecipe(const CommandLine& line, const std::string& input);

}  // namespace cli
