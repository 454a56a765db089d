// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/number_text.h"

#include <cstdlib>
#include <string>

namespace vdbtools {

std::optional<double> numberFromText(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);  // from_chars knows no plus sign
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  // Here strtod() tells the large from the small.
  if (error == std::errc::result_out_of_range) return std::strtod(std::string(text).c_str(), nullptr);
  return value;
}

}  // namespace vdbtools
