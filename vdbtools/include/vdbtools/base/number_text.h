// SPDX-License-Identifier: Apache-2.0
/// @file number_text.h
/// Numbers from text and to text, whatever the locale: of options, recipes and files alike. A plus sign may stand
/// before them. What a number means, and whether it may be what it is, is the caller's to say.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools {

/// The value of the whole @a text: infinite where it is too large for a double and 0 where it is too small, also "inf"
/// and "nan"; nothing if it is not a number.
std::optional<double> numberFromText(std::string_view text);

/// The same as a whole number; nothing either if Integer does not hold it.
template <class Integer>
std::optional<Integer> wholeFromText(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);  // from_chars knows no plus sign
  Integer value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Where a number is said to be a bound, rounding it must not make that untrue.
enum class Rounding { Nearest, Up, Down };

/// A number as people read it, in a message: four digits. Files and recipes have numbersText() instead, which is exact.
std::string shortText(double value, Rounding rounding = Rounding::Nearest);

}  // namespace vdbtools
