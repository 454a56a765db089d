// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"

#include <algorithm>
#include <cctype>
#include <vector>

namespace vdbtools {
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

}  // namespace vdbtools
