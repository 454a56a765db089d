// SPDX-License-Identifier: Apache-2.0
/// @file number_text.h
/// Conversion between numbers and text, independent of the locale, for options, recipes and files alike. Numbers may
/// have a plus sign. Callers decide what a number means and check its range.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools {

/// The value of the whole @a text, also "inf" and "nan". It is infinite if the number is too large for a double, and 0
/// if it is too small; nullopt if the text is not a number.
std::optional<double> numberFromText(std::string_view text);

/// As numberFromText(), for integers; also nullopt if the value does not fit Integer.
template <class Integer>
std::optional<Integer> wholeFromText(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);  // from_chars accepts no plus sign
  Integer value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// How shortText() rounds. A number that is quoted as a bound must be rounded so that it remains a bound.
enum class Rounding { Nearest, Up, Down };

/// A number with four digits, for messages. Files and recipes use numbersText() instead, which is exact.
std::string shortText(double value, Rounding rounding = Rounding::Nearest);

}  // namespace vdbtools
