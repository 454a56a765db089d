// SPDX-License-Identifier: Apache-2.0
/// @file option_groups.h
/// The headings under which the help lists the options of a recipe.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <map>
#include <string>

namespace cli {

class OptionGroups {
 public:
  /// Groups the options of a fractal by the rooms that declare them; other tables form one group.
  explicit OptionGroups(const vdbtools::OptionTable& table);

  std::string headingOf(const std::string& option) const;

 private:
  std::map<std::string, std::string> mHeadings;
  std::string mOthers;
};

/// Whether the short help describes an option of a recipe.
bool isBasic(const std::string& option);

}  // namespace cli
