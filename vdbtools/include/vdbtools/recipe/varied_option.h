// SPDX-License-Identifier: Apache-2.0
/// @file varied_option.h
/// An option that takes several values, one after the other: "alpha=10,20,40", "alpha=10:40:10".
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <string>
#include <vector>

namespace vdbtools {

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
