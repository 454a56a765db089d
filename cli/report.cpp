// SPDX-License-Identifier: Apache-2.0
#include "report.h"

#include "exit_code.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <iostream>

#include <unistd.h>

namespace cli {
namespace {

/// Whole numbers without a decimal point.
nlohmann::json numberOf(double value) {
  constexpr double kLargest = 9007199254740992;  // up to here doubles hold every whole number
  if (std::floor(value) == value && std::abs(value) <= kLargest) return static_cast<std::int64_t>(value);
  return value;
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

Report& report() {
  static Report theReport;
  return theReport;
}

void Report::start(std::string command, bool json) {
  const std::lock_guard lock(mMutex);
  mCommand = std::move(command);
  mJson = json;
  if (mJson) write({{"event", "start"}, {"version", JULIAVDB_VERSION}, {"share", mShare}});
}

std::ostream& Report::text() {
  if (mJson) return mText;
  return std::cerr;
}

void Report::count(const std::string& name, double value) {
  const std::lock_guard lock(mMutex);
  mCounts.emplace_back(name, value);
}

void Report::making(const std::filesystem::path& file, bool first) {
  const std::lock_guard lock(mMutex);
  if (first) mMaking.clear();
  mMaking.push_back(file.string());
}

void Report::wrote(const std::filesystem::path& file) {
  const std::lock_guard lock(mMutex);
  mWritten.push_back(file.string());
}

void Report::phaseEnded(const std::string& phase, double wall, double cpu, double share) {
  const std::lock_guard lock(mMutex);
  if (mEnded) return;
  const auto same = [&](const Phase& other) { return other.name == phase; };
  auto known = std::find_if(mPhases.begin(), mPhases.end(), same);
  if (known == mPhases.end()) known = mPhases.insert(known, {phase, 0, 0});
  known->wall += wall;
  known->cpu += cpu;
  mShare = std::max(mShare, share);
  if (mJson) write({{"event", "phase"}, {"phase", phase}, {"wall", wall}, {"cpu", cpu}, {"share", mShare}});
}

void Report::progress(nlohmann::json progress, double share) {
  const std::lock_guard lock(mMutex);
  if (mEnded) return;
  mShare = std::max(mShare, share);
  progress["event"] = "progress";
  progress["share"] = mShare;
  write(std::move(progress));
}

void Report::end(int exitCode, const std::string& error) {
  // Who holds the mutex may be waiting for a reader of stderr that is gone; an interruption does not wait for that.
  std::unique_lock lock(mMutex, std::chrono::milliseconds(100));
  if (mEnded) return;
  mEnded = true;
  if (!mJson) {
    if (!error.empty()) std::cerr << "juliavdb: " << error << std::endl;
    return;
  }
  nlohmann::json event{{"event", "end"},
                       {"ok", exitCode == kDone},
                       {"exit", exitCode},
                       {"share", exitCode == kDone ? 1.0 : mShare},
                       {"written", mWritten},
                       {"wall", wallSeconds()},
                       {"cpu", cpuSeconds()},
                       {"counts", nlohmann::json::object()},
                       {"phases", nlohmann::json::array()},
                       {"messages", nlohmann::json::array()}};
  if (!error.empty()) event["error"] = error;
  for (const auto& [name, value] : mCounts) event["counts"][name] = numberOf(value);
  for (const Phase& phase : mPhases)
    event["phases"].push_back({{"phase", phase.name}, {"wall", phase.wall}, {"cpu", phase.cpu}});
  // At an interruption the command may still be writing them.
  if (exitCode != kInterrupted) event["messages"] = linesOf(mText.str());
  write(std::move(event));
}

double Report::wallSeconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - mStart).count();
}

double Report::cpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void Report::write(nlohmann::json event) {
  event["command"] = mCommand;
  event["elapsed"] = wallSeconds();
  if (!mMaking.empty()) event["file"] = mMaking.front();
  if (mMaking.size() > 1) event["files"] = mMaking;
  // Names of files need not be UTF-8, but JSON is.
  const std::string line = event.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
  for (std::size_t at = 0; at < line.size();) {
    const ssize_t written = ::write(STDERR_FILENO, line.data() + at, line.size() - at);
    if (written <= 0) return;  // nobody is left to read it
    at += static_cast<std::size_t>(written);
  }
}

}  // namespace cli
