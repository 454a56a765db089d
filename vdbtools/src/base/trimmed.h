// SPDX-License-Identifier: Apache-2.0
/// @file trimmed.h
/// Trims text that people write.
#pragma once

#include <string_view>

namespace vdbtools {

/// The text without the blanks at its ends.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

}  // namespace vdbtools
