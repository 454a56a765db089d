// SPDX-License-Identifier: Apache-2.0
/// @file file_names.h
/// Replaces the names of files in recipes.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <map>
#include <string>

namespace vdbtools {

/// @a recipe with each first name of @a names replaced by the second, where it is the value of an option, or a part of
/// a value between colons. Only options that name files are changed; the hashes of their files stay.
Recipe withFileNames(const Recipe& recipe, const std::map<std::string, std::string>& names, const OptionTable& table);

}  // namespace vdbtools
