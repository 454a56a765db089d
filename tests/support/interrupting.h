// SPDX-License-Identifier: Apache-2.0
/// @file interrupting.h
/// A Monitor that cancels after a number of questions.
#pragma once

#include "vdbtools/base/monitor.h"

#include <atomic>
#include <cstdint>

namespace test_monitors {

/// Says that it was interrupted from the n-th question on.
class Interrupting : public vdbtools::Monitor {
 public:
  explicit Interrupting(std::int64_t from) : mFrom(from) {}
  bool cancelled() const override { return ++mAsked >= mFrom; }
  std::int64_t asked() const { return mAsked; }

 private:
  std::int64_t mFrom;
  mutable std::atomic<std::int64_t> mAsked{0};
};

}  // namespace test_monitors
