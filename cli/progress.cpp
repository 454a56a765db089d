// SPDX-License-Identifier: Apache-2.0
#include "progress.h"

#include "interruption.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <stdexcept>

#include <unistd.h>

namespace cli {
namespace {

constexpr std::chrono::seconds kQuiet(2);
// A terminal's line is redrawn; elsewhere each update is a line of a log.
constexpr std::chrono::milliseconds kTerminalPeriod(250), kLogPeriod(5000), kJsonPeriod(500);

double seconds(std::chrono::steady_clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

std::string duration(double s) {
  char text[32];
  if (s < 60)
    std::snprintf(text, sizeof text, "%.0f s", s);
  else
    std::snprintf(text, sizeof text, "%d:%02d min", static_cast<int>(s) / 60, static_cast<int>(s) % 60);
  return text;
}

}  // namespace

ProgressStyle parseProgressStyle(const std::string& text) {
  if (text == "bar") return ProgressStyle::Bar;
  if (text == "json") return ProgressStyle::Json;
  if (text == "none") return ProgressStyle::None;
  throw std::invalid_argument("--progress is '" + text + "'; it must be one of bar, json, none");
}

Progress::Progress(ProgressStyle style) : mStyle(style), mTerminal(isatty(STDERR_FILENO) != 0) {
  if (mStyle != ProgressStyle::None) mThread = std::thread([this] { watch(); });
}

Progress::~Progress() {
  {
    const std::lock_guard lock(mMutex);
    mStop = true;
  }
  mWake.notify_all();
  if (mThread.joinable()) mThread.join();
  clearLine();
}

void Progress::begin(std::string_view phase, std::uint64_t total) {
  throwIfCancelled();
  const std::lock_guard lock(mMutex);
  mPhase = phase;
  mTotal = total;
  mDone = 0;
  mPhaseStart = Clock::now();
}

bool Progress::cancelled() const { return interrupted(); }

void Progress::watch() {
  const auto period = mStyle == ProgressStyle::Json ? kJsonPeriod : mTerminal ? kTerminalPeriod : kLogPeriod;
  std::unique_lock lock(mMutex);
  auto next = mStart + kQuiet;
  while (!mWake.wait_until(lock, next, [this] { return mStop; })) {
    show();
    next = Clock::now() + period;
  }
}

void Progress::show() {
  if (mPhase.empty()) return;
  const auto now = Clock::now();
  const double elapsed = seconds(now - mStart), inPhase = seconds(now - mPhaseStart);
  const double fraction = mTotal ? std::min(1.0, static_cast<double>(mDone) / static_cast<double>(mTotal)) : 0;
  const bool known = fraction > 0.01;
  const double left = known ? inPhase * (1 - fraction) / fraction : 0;
  if (mStyle == ProgressStyle::Json) {
    nlohmann::json line{{"phase", mPhase}, {"elapsed", elapsed}};
    if (mTotal) line["fraction"] = fraction;
    if (known) line["left"] = left;
    std::cerr << line.dump() << std::endl;
    return;
  }
  constexpr int kWidth = 24;
  const int filled = static_cast<int>(fraction * kWidth);
  std::string text = mPhase + " ";
  if (mTotal) {
    text += "[" + std::string(static_cast<std::size_t>(filled), '#') +
            std::string(static_cast<std::size_t>(kWidth - filled), '.') + "] " +
            std::to_string(static_cast<int>(fraction * 100)) + " %";
    if (known) text += ", " + duration(left) + " left";
  } else {
    text += "for " + duration(inPhase);
  }
  if (mTerminal) {
    std::cerr << "\r\033[K" << text << std::flush;
    mLineShown = true;
  } else {
    std::cerr << text << std::endl;
  }
}

void Progress::clearLine() {
  if (mLineShown) std::cerr << "\r\033[K" << std::flush;
}

}  // namespace cli
