// SPDX-License-Identifier: Apache-2.0
/// @file made_recipe.h
/// The recipe in a file that was dropped on the page. The bytes are the user's, or anybody's: they are read with care,
/// and never reach the disk.
#pragma once

#include "vdbtools/maps/map_registry.h"
#include "vdbtools/recipe/option_table.h"

#include <string>
#include <string_view>

namespace vdbtools::explore {

/// Of a file that 'juliavdb fractal' made, in a format that holds the recipe, or of a text of lines NAME = VALUE as
/// --config takes them.
/// @param name  of the file: its extension says what it is
/// @return the recipe as it is recorded, completed and with hashes; of a text what it says
/// @throw DataError              it holds no recipe of a fractal, or a broken one
/// @throw std::invalid_argument  another kind of file
Recipe recipeOfMadeFile(const std::string& name, std::string_view bytes);

/// What was recorded of another target, for the target at hand.
/// @param target  options of the target at hand, as they were given
Recipe overTarget(Recipe recorded, const Recipe& target);

}  // namespace vdbtools::explore
