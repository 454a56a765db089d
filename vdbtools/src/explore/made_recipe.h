// SPDX-License-Identifier: Apache-2.0
/// @file made_recipe.h
/// Reads the recipe in a file that was dropped on the page. The bytes are untrusted, and never reach the disk.
#pragma once

#include "vdbtools/maps/map_registry.h"
#include "vdbtools/recipe/option_table.h"

#include <string>
#include <string_view>

namespace vdbtools::explore {

/// The recipe in a file that 'juliavdb fractal' made, or in a text with lines NAME = VALUE, as --config
/// takes them.
/// @param name  the file name, whose extension gives the format
/// @return the recipe as it is recorded, completed and with hashes; for a text, only its entries
/// @throw DataError              it contains no recipe of a fractal, or a broken one
/// @throw std::invalid_argument  another kind of file
Recipe recipeOfMadeFile(const std::string& name, std::string_view bytes);

/// Replaces the target of a recipe that was recorded for another one.
/// @param target  the options of the current target, as they were given
Recipe overTarget(Recipe recorded, const Recipe& target);

}  // namespace vdbtools::explore
