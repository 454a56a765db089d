// SPDX-License-Identifier: Apache-2.0
/// @file monitor.h
/// The interface between long work and the code that watches it: work reports progress and asks whether it is
/// cancelled.
#pragma once

#include "vdbtools/base/errors.h"
#include "vdbtools/base/phase.h"

#include <cstdint>

namespace vdbtools {

/// Watches a piece of work. The default one shows nothing and never cancels.
/// advance() and cancelled() are called from many threads at once.
class Monitor {
 public:
  virtual ~Monitor() = default;

  /// A phase of @a total steps begins; 0 means that the number of steps is not known.
  virtual void begin(const Phase& phase, std::uint64_t total) {
    (void)phase;
    (void)total;
  }

  /// @a steps more of the current phase are done.
  virtual void advance(std::uint64_t steps) { (void)steps; }

  /// Whether the work is to stop.
  virtual bool cancelled() const { return false; }

  /// @throw Interrupted  the work is to stop
  void throwIfCancelled() const {
    if (cancelled()) throw Interrupted("interrupted; nothing was written");
  }
};

/// A Monitor with the interface that OpenVDB's tools expect (util::NullInterrupter).
class OpenVdbInterrupter {
 public:
  explicit OpenVdbInterrupter(const Monitor& monitor) : mMonitor(monitor) {}
  void start(const char* = nullptr) {}
  void end() {}
  bool wasInterrupted(int = -1) const { return mMonitor.cancelled(); }

 private:
  const Monitor& mMonitor;
};

}  // namespace vdbtools
