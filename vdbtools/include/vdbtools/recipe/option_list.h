// SPDX-License-Identifier: Apache-2.0
/// @file option_list.h
/// Options in a text: lines NAME = VALUE. What follows a # is a comment, and blanks about a name and a value do not
/// count.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

struct ListedOption {
  std::size_t line;        ///< from 1
  std::string name;        ///< empty: the line does not read NAME = VALUE
  std::string_view value;  ///< a part of the text; of such a line, all of it
};

/// In the order of the text, without empty lines and comments.
std::vector<ListedOption> listedOptions(std::string_view text);

}  // namespace vdbtools
