// SPDX-License-Identifier: Apache-2.0
#include "progress.h"

#include "interruption.h"
#include "report.h"

#include "vdbtools/recipe/option_value.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <new>
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
  vdbtools::refuseChoice("progress", text, std::vector<std::string>{"bar", "json", "none"});
}

Progress::Progress(ProgressStyle style, std::string_view command)
    : mStyle(style), mTerminal(isatty(STDERR_FILENO) != 0), mShare(phasesOf(command)) {
  if (!phasesOf(command).empty()) begin(vdbtools::PhaseKind::Reading, 0);
  if (mStyle == ProgressStyle::None) return;
  mThread = std::thread([this] {
    try {
      watch();
    } catch (const std::bad_alloc&) {
      // The work continues without a display, or fails for the same reason.
    }
  });
}

Progress::~Progress() {
  {
    const std::lock_guard lock(mMutex);
    mStop = true;
    try {
      endPhase();
    } catch (const std::bad_alloc&) {
      // The work has failed for the same reason.
    }
  }
  mWake.notify_all();
  if (mThread.joinable()) mThread.join();
  clearLine();
}

void Progress::begin(const vdbtools::Phase& phase, std::uint64_t total) {
  throwIfCancelled();
  const std::lock_guard lock(mMutex);
  endPhase();
  mPhase = phase.text();
  mTotal = total;
  mDone = 0;
  mPhaseStart = Clock::now();
  mPhaseCpu = Report::cpuSeconds();
  mShare.begin(phase);
}

bool Progress::cancelled() const { return interrupted(); }

void Progress::endPhase() {
  if (mPhase.empty()) return;
  // An abandoned phase is over, but not done.
  const double share = mShare.at(interrupted() ? fraction() : mStop ? 0 : 1);
  report().phaseEnded(mPhase, seconds(Clock::now() - mPhaseStart), Report::cpuSeconds() - mPhaseCpu, share);
}

void Progress::watch() {
  const bool json = mStyle == ProgressStyle::Json;
  const auto period = json ? kJsonPeriod : mTerminal ? kTerminalPeriod : kLogPeriod;
  std::unique_lock lock(mMutex);
  auto next = mStart + (json ? Clock::duration(kJsonPeriod) : Clock::duration(kQuiet));
  while (!mWake.wait_until(lock, next, [this] { return mStop; })) {
    if (!mPhase.empty()) json ? showEvent() : show();
    next = Clock::now() + period;
  }
}

double Progress::fraction() const {
  return mTotal ? std::min(1.0, static_cast<double>(mDone) / static_cast<double>(mTotal)) : 0;
}

void Progress::showEvent() {
  constexpr double kKnown = 0.01;  // the share from which the remaining time is estimated
  const auto now = Clock::now();
  const double part = fraction(), whole = mShare.at(part);
  nlohmann::json event{{"phase", mPhase}};
  if (mTotal) event["fraction"] = part;
  if (part > kKnown) event["phaseLeft"] = seconds(now - mPhaseStart) * (1 - part) / part;
  // While the length of a phase is unknown, the share stands still, and the estimate would seem to grow.
  if (mTotal && whole > kKnown) event["left"] = seconds(now - mStart) * (1 - whole) / whole;
  report().progress(std::move(event), whole);
}

void Progress::show() {
  const double part = fraction(), inPhase = seconds(Clock::now() - mPhaseStart);
  constexpr int kWidth = 24;
  const int filled = static_cast<int>(part * kWidth);
  std::string text = mPhase + " ";
  if (mTotal) {
    text += "[" + std::string(static_cast<std::size_t>(filled), '#') +
            std::string(static_cast<std::size_t>(kWidth - filled), '.') + "] " +
            std::to_string(static_cast<int>(part * 100)) + " %";
    // An estimate below a second says nothing, and the last steps may take longer than it says.
    if (const double left = inPhase * (1 - part) / part; part > 0.01 && left >= 1)
      text += ", " + duration(left) + " left";
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
