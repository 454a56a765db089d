// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"

namespace vdbtools {

std::string_view withoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

std::size_t characterAt(std::string_view text, std::size_t at) {
  constexpr std::size_t kMostContinued = 3;  // a character has four bytes at most
  const auto continues = [&](std::size_t k) {
    return k < text.size() && (static_cast<unsigned char>(text[k]) & 0xC0) == 0x80;
  };
  std::size_t start = at;
  for (std::size_t k = 0; k < kMostContinued && start > 0 && continues(start); ++k) --start;
  return continues(start) ? at : start;
}

}  // namespace vdbtools
