// SPDX-License-Identifier: Apache-2.0
/// @file file_names.h
/// Recipes with other names of their files.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <map>
#include <string>

namespace vdbtools {

/// @a recipe with each of @a names, as an option's value or as a part of it between colons, replaced by its second.
/// Only options that name files are touched, and the hashes of their files stay.
Recipe withFileNames(const Recipe& recipe, const std::map<std::string, std::string>& names, const OptionTable& table);

}  // namespace vdbtools
