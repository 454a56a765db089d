// SPDX-License-Identifier: Apache-2.0
/// @file timed_part.h
/// Helpers to estimate the duration of some work by doing a part of it.
#pragma once

#include "vdbtools/base/monitor.h"

#include <ctime>

namespace vdbtools {

/// The CPU time of all threads of the process.
inline double cpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Forwards only the cancellation.
class QuietMonitor final : public Monitor {
 public:
  explicit QuietMonitor(const Monitor& monitor) : mMonitor(monitor) {}
  bool cancelled() const override { return mMonitor.cancelled(); }

 private:
  const Monitor& mMonitor;
};

}  // namespace vdbtools
