// SPDX-License-Identifier: Apache-2.0
/// @file numbered_monitor.h
/// The phases of one of several pieces of work under names of their own: "render, frame 3 of 24".
#pragma once

#include "vdbtools/base/monitor.h"

#include <string>

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

}  // namespace vdbtools
