// SPDX-License-Identifier: Apache-2.0
/// @file numbered_monitor.h
/// The phases of one of several pieces of work: "render, frame 3 of 24".
#pragma once

#include "vdbtools/base/monitor.h"

#include <cstddef>
#include <string>
#include <utility>

namespace vdbtools {

class NumberedMonitor final : public Monitor {
 public:
  /// @param monitor  must outlive this
  /// @param piece    what is counted, such as "frame"
  /// @param number   of this piece, from 1 to @a count
  NumberedMonitor(Monitor& monitor, std::string piece, std::size_t number, std::size_t count)
      : mMonitor(monitor), mPiece(std::move(piece)), mNumber(number), mCount(count) {}

  void begin(const Phase& phase, std::uint64_t total) override {
    Phase numbered = phase;
    numbered.piece = mPiece;
    numbered.number = mNumber;
    numbered.count = mCount;
    mMonitor.begin(numbered, total);
  }
  void advance(std::uint64_t steps) override { mMonitor.advance(steps); }
  bool cancelled() const override { return mMonitor.cancelled(); }

 private:
  Monitor& mMonitor;
  std::string mPiece;
  std::size_t mNumber, mCount;
};

}  // namespace vdbtools
