// SPDX-License-Identifier: Apache-2.0
/// @file progress.h
/// Progress on stderr: a bar with the remaining time, for work of more than two seconds, or events of the report.
#pragma once

#include "overall_share.h"

#include "vdbtools/base/monitor.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace cli {

enum class ProgressStyle { Bar, Json, None };

/// @throw std::invalid_argument unless it is bar, json or none
ProgressStyle parseProgressStyle(const std::string& text);

class Progress final : public vdbtools::Monitor {
 public:
  /// @param command  determines which phases to expect
  Progress(ProgressStyle style, std::string_view command);
  ~Progress() override;
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin(const vdbtools::Phase& phase, std::uint64_t total) override;
  void advance(std::uint64_t steps) override { mDone.fetch_add(steps, std::memory_order_relaxed); }
  bool cancelled() const override;

 private:
  using Clock = std::chrono::steady_clock;
  void watch();
  void show();
  void showEvent();
  void clearLine();
  double fraction() const;
  void endPhase();

  ProgressStyle mStyle;
  bool mTerminal;
  Clock::time_point mStart = Clock::now(), mPhaseStart = mStart;
  double mPhaseCpu = 0;  ///< CPU time of the process at the beginning of the phase, seconds
  OverallShare mShare;
  std::mutex mMutex;  // guards everything below but mDone
  std::condition_variable mWake;
  bool mStop = false, mLineShown = false;
  std::string mPhase;
  std::uint64_t mTotal = 0;
  std::atomic<std::uint64_t> mDone{0};
  std::thread mThread;
};

}  // namespace cli
