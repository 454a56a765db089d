// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"

namespace vdbtools {

std::string shellWord(std::string_view word) {
  // Characters without a special meaning in any shell; the last one must not come first.
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+./:,@%=";
  if (!word.empty() && !word.starts_with('=') && word.find_first_not_of(kPlain) == word.npos) return std::string(word);
  std::string text = "'";
  for (const char c : word) {
    if (c == '\'')
      text += "'\\''";
    else
      text += c;
  }
  return text + "'";
}

}  // namespace vdbtools
