// SPDX-License-Identifier: Apache-2.0
/// @file text.h
/// Texts: lists of words, numbers, misspelt words, words of a shell, and UTF-8.
#pragma once

#include <charconv>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

/// "a, b, c". @param textOf  makes the text of an element
template <class List, class TextOf = std::identity>
std::string joined(const List& list, std::string_view between = ", ", TextOf textOf = {}) {
  std::string text;
  for (const auto& element : list) {
    if (!text.empty()) text += between;
    text += std::invoke(textOf, element);
  }
  return text;
}

// Conversion between numbers and text, independent of the locale, for options, recipes and files alike. Numbers may
// have a plus sign. Callers decide what a number means and check its range.

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

/// The text without the blanks at its ends.
std::string_view trimmed(std::string_view text);

/// The bytes that "%20" and the like stand for in an address, RFC 3986 2.1. A percent sign without two hexadecimal
/// digits behind it stands for itself.
std::string percentDecoded(std::string_view text);

// Suggests the word that was meant by a misspelt one.

/// The number of letters that must be inserted, deleted, replaced, or exchanged with their neighbour to turn one word
/// into the other, where no part is edited twice ([Dam64]).
std::size_t editDistance(std::string_view a, std::string_view b);

/// Returns the word that was probably meant: one that begins with @a word, or else one that differs from it in up to a
/// third of its letters, ignoring case. It is the nearest such word, and the first of equally near ones; nullopt if no
/// word is that near.
std::optional<std::string> nearestWord(std::string_view word, std::span<const std::string> known);

/// "; did you mean 'x'?", or an empty text.
/// @param prefix  what is typed before the word
std::string didYouMean(std::string_view word, std::span<const std::string> known, const std::string& prefix = "");

// Quotes words of commands that can be pasted into a shell.

/// Returns a word of a POSIX shell that stands for exactly @a word, quoted if necessary.
std::string shellWord(std::string_view word);

// Finds where UTF-8 text begins and where it may be cut.

/// Returns the text after the byte order mark, if there is one. Some editors and exporters put these three bytes at the
/// beginning of UTF-8; they carry no meaning and are not part of the first word.
std::string_view withoutByteOrderMark(std::string_view text);

/// Returns the last position at or before @a at where a character of @a text begins or the text ends, so that cutting
/// there splits no character. In bytes that are not UTF-8, any position is acceptable, and the result is close to @a
/// at.
/// @param at  in bytes, at most the size of @a text
std::size_t characterAt(std::string_view text, std::size_t at);

}  // namespace vdbtools
