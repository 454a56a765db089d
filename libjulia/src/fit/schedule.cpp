// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/schedule.h"

#include <charconv>
#include <stdexcept>

namespace julia {
namespace {

constexpr std::string_view kLetters = "VFR";
constexpr int kLeast = 4, kMost = 1000;

[[noreturn]] void refuse(std::string_view text, std::size_t at, const std::string& wanted) {
  const std::string found = at < text.size() ? "'" + std::string(1, text[at]) + "'" : "its end";
  throw std::invalid_argument("the schedule '" + std::string(text) + "' has " + found + " at character " +
                              std::to_string(at + 1) + " where " + wanted +
                              " is expected; one that works is 25(VFRF) 50(VFRF) 97(VF)");
}

}  // namespace

std::vector<FitPass> parseSchedule(std::string_view text) {
  std::vector<FitPass> schedule;
  std::size_t at = 0;
  const auto skipBlanks = [&] {
    while (at < text.size() && text[at] == ' ') ++at;
  };
  skipBlanks();
  do {
    int resolution = 0;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), resolution);
    if (error != std::errc{} || resolution < kLeast || resolution > kMost)
      refuse(text, at, "a resolution from " + std::to_string(kLeast) + " to " + std::to_string(kMost));
    at = static_cast<std::size_t>(end - text.data());
    skipBlanks();
    if (at >= text.size() || text[at] != '(') refuse(text, at, "'('");
    const std::size_t first = ++at;
    for (; at < text.size() && text[at] != ')'; ++at) {
      const std::size_t kind = kLetters.find(text[at]);
      if (kind == std::string_view::npos) refuse(text, at, "V, F, R or ')'");
      schedule.push_back({resolution, static_cast<FitPassKind>(kind)});
    }
    if (at >= text.size()) refuse(text, at, "V, F, R or ')'");
    if (at == first) refuse(text, at, "V, F or R");
    ++at;
    skipBlanks();
  } while (at < text.size());
  return schedule;
}

std::string toString(const std::vector<FitPass>& schedule) {
  std::string text;
  for (std::size_t i = 0; i < schedule.size(); ++i) {
    if (i == 0 || schedule[i].resolution != schedule[i - 1].resolution) {
      if (i > 0) text += ") ";
      text += std::to_string(schedule[i].resolution) + "(";
    }
    text += kLetters[static_cast<std::size_t>(schedule[i].kind)];
  }
  return schedule.empty() ? text : text + ")";
}

}  // namespace julia
