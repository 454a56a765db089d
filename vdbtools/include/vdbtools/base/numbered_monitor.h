// SPDX-License-Identifier: Apache-2.0
/// @file numbered_monitor.h
/// The phases of one of several pieces of work under names of their own: "render, frame 3 of 24".
#pragma once

#include "vdbtools/base/monitor.h"

#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>

namespace vdbtools {

class NumberedMonitor final : public Monitor {
 public:
  /// @param monitor  must outlive this
  /// @param what     what is counted, such as "frame"
  /// @param number   of this piece, from 1 to @a count
  NumberedMonitor(Monitor& monitor, const std::string& what, std::size_t number, std::size_t count)
      : mMonitor(monitor), mSuffix(", " + what + " " + std::to_string(number) + " of " + std::to_string(count)) {}

  void begin(std::string_view phase, std::uint64_t total) override {
    mMonitor.begin(std::string(phase) + mSuffix, total);
  }
  void advance(std::uint64_t steps) override { mMonitor.advance(steps); }
  bool cancelled() const override { return mMonitor.cancelled(); }

 private:
  Monitor& mMonitor;
  std::string mSuffix;
};

/// What NumberedMonitor made of a phase's name; the number and the count are 0 for another name.
struct NumberedPhase {
  std::string_view phase;  ///< a part of the given name
  std::size_t number = 0, count = 0;
};
inline NumberedPhase numberedPhase(std::string_view name) {
  const std::size_t comma = name.rfind(", "), of = name.rfind(" of ");
  if (comma == name.npos || of == name.npos || of < comma) return {name};
  const std::size_t space = name.rfind(' ', of - 1);
  const auto whole = [](std::string_view text) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? value : 0;
  };
  const std::size_t number = whole(name.substr(space + 1, of - space - 1)), count = whole(name.substr(of + 4));
  if (number == 0 || number > count) return {name};
  return {name.substr(0, comma), number, count};
}

}  // namespace vdbtools
