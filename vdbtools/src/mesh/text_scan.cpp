// SPDX-License-Identifier: Apache-2.0
#include "mesh/text_scan.h"

#include "vdbtools/base/errors.h"

#include <charconv>
#include <cmath>
#include <cstdlib>

namespace vdbtools {
namespace {

constexpr std::string_view kBlank = " \t\r\v\f";

}  // namespace

std::string_view WordScanner::next() {
  const std::size_t begin = mRest.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) {
    mRest = {};
    return {};
  }
  const std::size_t end = std::min(mRest.find_first_of(kBlank, begin), mRest.size());
  const std::string_view word = mRest.substr(begin, end - begin);
  mRest.remove_prefix(end);
  return word;
}

std::optional<std::string_view> LineScanner::next() {
  if (mRest.empty()) return std::nullopt;
  const std::size_t end = std::min(mRest.find('\n'), mRest.size());
  const std::string_view line = mRest.substr(0, end);
  mRest.remove_prefix(std::min(end + 1, mRest.size()));
  ++mLineNumber;
  return line;
}

std::optional<std::string_view> LineScanner::nextMeaningful() {
  while (const auto line = next()) {
    const std::string_view cut = line->substr(0, line->find('#'));
    if (cut.find_first_not_of(kBlank) != std::string_view::npos) return cut;
  }
  return std::nullopt;
}

void LineScanner::fail(const std::string& what) const {
  throw DataError(mPath.string() + ", line " + std::to_string(mLineNumber) + ": " + what);
}

double LineScanner::number(std::string_view word) const {
  const auto value = parseNumber(word);
  if (!value) fail(shown(word) + " stands where a number should; the file is damaged or truncated: export it again");
  if (!std::isfinite(*value)) fail("the number " + shown(word) + " is not finite; repair the mesh and export it again");
  return *value;
}

long long LineScanner::integer(std::string_view word) const {
  if (word.starts_with('+')) word.remove_prefix(1);
  long long value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) {
    fail(shown(word) + " stands where a whole number should; the file is damaged or truncated: export it again");
  }
  return value;
}

std::optional<double> parseNumber(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);  // from_chars knows no plus sign
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) return std::strtod(std::string(word).c_str(), nullptr);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::string shown(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "'";
  for (const char c : word.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > kLongest ? "...'" : "'");
}

}  // namespace vdbtools
