// SPDX-License-Identifier: Apache-2.0
/// @file shell_command.h
/// Recipes as commands that can be pasted into a shell.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbtools {

/// One word of a POSIX shell that stands for exactly @a word, in quotes where they are needed.
std::string shellWord(std::string_view word);

/// The command that makes what a recipe describes: "juliavdb fractal bunny.obj --detail 0.6 -o look.vdb".
/// @param recipe   what was given; entries for hashes, flags that are off, and options without an effect on the
///                 outputs are left out
/// @param table    that of the command
/// @param outputs  options and files, such as ("-o", "look.vdb")
std::string fractalCommand(const Recipe& recipe, const OptionTable& table,
                           const std::vector<std::pair<std::string, std::string>>& outputs);

/// What of a recipe has to be given for it to be completed to the same.
Recipe shortestRecipe(const Recipe& recipe, const OptionTable& table);

}  // namespace vdbtools
