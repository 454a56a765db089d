// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"

#include <cmath>
#include <cstdlib>
#include <iterator>

namespace vdbtools {

std::optional<double> numberFromText(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);  // from_chars accepts no plus sign
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  // Here strtod() distinguishes overflow from underflow.
  if (error == std::errc::result_out_of_range) return std::strtod(std::string(text).c_str(), nullptr);
  return value;
}

std::string shortText(double value, Rounding rounding) {
  constexpr int kDigits = 4;
  const double step = std::abs(value) * 5e-5;  // at most half a unit of the last digit
  for (double at = value;; at += rounding == Rounding::Up ? step : -step) {
    char digits[32];
    const std::string text(digits,
                           std::to_chars(digits, std::end(digits), at, std::chars_format::general, kDigits).ptr);
    const double read = numberFromText(text).value_or(value);
    const bool holds = rounding == Rounding::Up ? read >= value : rounding == Rounding::Down ? read <= value : true;
    if (holds || !(step > 0) || !std::isfinite(step)) return text;
  }
}

}  // namespace vdbtools
