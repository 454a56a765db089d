// SPDX-License-Identifier: Apache-2.0
/// @file progress.h
/// Progress on stderr: a bar with the time left, or JSON lines for other programs. Nothing for work under two seconds.
#pragma once

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
  explicit Progress(ProgressStyle style);
  ~Progress() override;
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin(std::string_view phase, std::uint64_t total) override;
  void advance(std::uint64_t steps) override { mDone.fetch_add(steps, std::memory_order_relaxed); }
  bool cancelled() const override;

 private:
  using Clock = std::chrono::steady_clock;
  void watch();
  void show();
  void clearLine();

  ProgressStyle mStyle;
  bool mTerminal;
  Clock::time_point mStart = Clock::now(), mPhaseStart = mStart;
  std::mutex mMutex;  // of everything below but mDone
  std::condition_variable mWake;
  bool mStop = false, mLineShown = false;
  std::string mPhase;
  std::uint64_t mTotal = 0;
  std::atomic<std::uint64_t> mDone{0};
  std::thread mThread;
};

}  // namespace cli
