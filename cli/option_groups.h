// SPDX-License-Identifier: Apache-2.0
/// @file option_groups.h
/// Under which headings the help lists the options of a recipe.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <map>
#include <string>

namespace cli {

class OptionGroups {
 public:
  /// Of the options of a fractal, by the rooms that declare them; other tables are one group.
  explicit OptionGroups(const vdbtools::OptionTable& table);

  std::string headingOf(const std::string& option) const;

 private:
  std::map<std::string, std::string> mHeadings;
  std::string mOthers;
};

/// Whether an option is among the few of a recipe that the short help describes.
bool isBasic(const std::string& option);

}  // namespace cli
