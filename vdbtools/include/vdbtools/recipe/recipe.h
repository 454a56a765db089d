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

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// "julia_" and the name with underscores: an identifier, as Houdini wants it.
std::string metadataName(const std::string& option);

/// A recipe's entries as metadata, with the tool's version and the command.
std::map<std::string, std::string> recipeToMetadata(const Recipe& recipe, const std::string& command);

/// The command that made what has this metadata; "" if it was none of ours.
std::string commandOfMetadata(const std::map<std::string, std::string>& metadata);

/// The entries of @a metadata that are options of @a table, or hashes of files that these name.
Recipe recipeFromMetadata(const std::map<std::string, std::string>& metadata, const OptionTable& table);

// The names that options had up to version 1.0, where recipes called the texture by its name in the papers, *versor*.
// Everything that reads names takes both; everything that writes them writes today's.

/// Today's name of an option: "texture-seed" for "versor-seed". All other names are returned as they are.
std::string currentName(std::string_view name);
/// The name that an option had before: "versor-seed" for "texture-seed".
std::string formerName(std::string_view name);

// Options in a text: lines NAME = VALUE. What follows a # is a comment, and blanks about a name and a value do not
// count.

struct ListedOption {
  std::size_t line;        ///< from 1
  std::string name;        ///< empty: the line does not read NAME = VALUE
  std::string_view value;  ///< a part of the text; of such a line, all of it
};

/// In the order of the text, without empty lines and comments.
std::vector<ListedOption> listedOptions(std::string_view text);

// An option that takes several values, one after the other: "alpha=10,20,40", "alpha=10:40:10".

struct VariedOption {
  std::string name;
  std::vector<std::string> values;  ///< at least one, none of them empty

  bool operator==(const VariedOption&) const = default;
};

/// Reads "NAME=VALUES". The values stand between commas, or between semicolons if there is one in the text: then a
/// value may hold commas ("origin=0,0,0;0.1,0,0"), and a semicolon may also stand at the end. "A:B:STEP" among
/// them stands for A, A + STEP and so on, up to B at the most, computed in decimals: "0:0.3:0.1" ends with 0.3 and has
/// no value like 0.30000000000000004.
/// @param most  how many values there may be
/// @throw std::invalid_argument  no such option, no value, an empty one, too many, or a range without an end
VariedOption parseVaried(const std::string& text, const OptionTable& table, std::size_t most);

}  // namespace vdbtools
