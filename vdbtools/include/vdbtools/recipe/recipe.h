// SPDX-License-Identifier: Apache-2.0
/// @file recipe.h
/// The room `recipe` turns text into values: option_table.h says which options a command has, recipe_reader.h reads a
/// recipe by such a table, and option_value.h reads single values. Which options there are is up to the rooms that own
/// them. It may use base, files, mesh and formats.
///
/// Here: a recipe is what a run was asked to do, as text: option names and values, in the words of the command line. It
/// goes into the metadata of what was made and comes back from there, so that a file says how to make it again.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <map>
#include <string>

namespace vdbtools {

/// "julia_" and the name with underscores: an identifier, as Houdini wants it.
std::string metadataName(const std::string& option);

/// A recipe's entries as metadata, with the tool's version and the command.
std::map<std::string, std::string> recipeToMetadata(const Recipe& recipe, const std::string& command);

/// The command that made what has this metadata; "" if it was none of ours.
std::string commandOfMetadata(const std::map<std::string, std::string>& metadata);

/// The entries of @a metadata that are options of @a table, or hashes of files that these name.
Recipe recipeFromMetadata(const std::map<std::string, std::string>& metadata, const OptionTable& table);

}  // namespace vdbtools
