// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"

#include "base/from_chars.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <vector>

namespace vdbtools {

std::optional<double> numberFromText(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);  // from_chars accepts no plus sign
  double value = 0;
  const auto [end, error] = fromChars(text.data(), text.data() + text.size(), value);
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

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::string percentDecoded(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned char byte = 0;
    if (text[i] == '%' && text.size() - i > 2) {
      const char* const end = text.data() + i + 3;
      if (std::from_chars(end - 2, end, byte, 16).ptr == end) {
        result += static_cast<char>(byte);
        i += 2;
        continue;
      }
    }
    result += text[i];
  }
  return result;
}

namespace {

constexpr std::size_t kLettersToGuess = 3;  ///< a shorter word could stand for any other

std::string lower(std::string_view word) {
  std::string result(word);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

}  // namespace

std::size_t editDistance(std::string_view a, std::string_view b) {
  const std::size_t width = b.size() + 1;
  std::vector<std::size_t> table((a.size() + 1) * width);
  const auto at = [&](std::size_t i, std::size_t j) -> std::size_t& { return table[i * width + j]; };
  for (std::size_t i = 0; i <= a.size(); ++i) at(i, 0) = i;
  for (std::size_t j = 0; j <= b.size(); ++j) at(0, j) = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = at(i - 1, j - 1) + (a[i - 1] == b[j - 1] ? 0 : 1);
      at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
    }
  return at(a.size(), b.size());
}

std::optional<std::string> nearestWord(std::string_view word, std::span<const std::string> known) {
  constexpr std::size_t kLongest = 100;  // anything longer is not a word
  if (word.size() < kLettersToGuess || word.size() > kLongest) return std::nullopt;
  const std::string wanted = lower(word);
  const std::size_t most = std::max<std::size_t>(1, wanted.size() / 3);
  const std::string* best = nullptr;
  std::size_t least = most + 1;
  for (const std::string& each : known) {
    const std::string candidate = lower(each);
    const std::size_t distance = candidate.starts_with(wanted) ? 0 : editDistance(wanted, candidate);
    if (distance < least && distance < candidate.size()) {
      best = &each;
      least = distance;
    }
  }
  return best ? std::optional(*best) : std::nullopt;
}

std::string didYouMean(std::string_view word, std::span<const std::string> known, const std::string& prefix) {
  const std::optional<std::string> meant = nearestWord(word, known);
  return meant ? "; did you mean '" + prefix + *meant + "'?" : std::string();
}

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
