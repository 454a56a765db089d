// SPDX-License-Identifier: Apache-2.0
/// @file option_name.h
/// The names that options had up to version 1.0, where recipes called the texture by its name in the papers, *versor*.
/// Everything that reads names takes both; everything that writes them writes today's.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// Today's name of an option: "texture-seed" for "versor-seed". All other names are returned as they are.
std::string currentName(std::string_view name);
/// The name that an option had before: "versor-seed" for "texture-seed".
std::string formerName(std::string_view name);

}  // namespace vdbtools
