// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/text_scan.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <algorithm>
#include <cmath>

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

double LineScanner::anyNumber(std::string_view word) const {
  const auto value = numberFromText(word);
  if (!value)
    fail(shown(word) + " stands where a number is expected; the file is damaged or truncated: export it again");
  return *value;
}

double LineScanner::number(std::string_view word) const {
  const double value = anyNumber(word);
  if (!std::isfinite(value)) fail("the number " + shown(word) + " is not finite; repair the mesh and export it again");
  return value;
}

long long LineScanner::integer(std::string_view word) const {
  const auto value = wholeFromText<long long>(word);
  if (!value) {
    fail(shown(word) + " stands where a whole number is expected; the file is damaged or truncated: export it again");
  }
  return *value;
}

openvdb::Vec3d LineScanner::point(WordScanner& words) const {
  openvdb::Vec3d point;
  for (int axis = 0; axis < 3; ++axis) point[axis] = anyNumber(words.next());
  return point;
}

std::string shown(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "'";
  for (const char c : word.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > kLongest ? "...'" : "'");
}

}  // namespace vdbtools
