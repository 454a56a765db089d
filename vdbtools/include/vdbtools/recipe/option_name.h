// SPDX-License-Identifier: Apache-2.0
/// @file option_name.h
/// What options are called where users see them. Recipes keep the names of the theory, whose *versor* is an artist's
/// *texture*: the entry "versor-seed" is the option --texture-seed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// The option for an entry of a recipe, without dashes in front: "texture-seed" for "versor-seed". All other entries
/// are called like their options.
std::string optionName(std::string_view entry);

/// The same for each of several entries.
std::vector<std::string> optionNames(std::vector<std::string> entries);

/// The entry of a recipe for an option or for the entry itself: "versor-seed" for both names.
std::string recipeEntry(std::string_view name);

}  // namespace vdbtools
