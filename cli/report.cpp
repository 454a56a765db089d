// SPDX-License-Identifier: Apache-2.0
#include "report.h"

#include "exit_code.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <iostream>
#include <sstream>
#include <thread>

#include <sys/resource.h>
#include <unistd.h>

namespace cli {
namespace {

/// Integers are written without a decimal point.
nlohmann::json jsonOf(double value) {
  constexpr double kLargest = 9007199254740992;  // up to here doubles represent every integer
  if (std::floor(value) == value && std::abs(value) <= kLargest) return static_cast<std::int64_t>(value);
  return value;
}
template <std::integral Whole>
nlohmann::json jsonOf(Whole value) {
  return value;
}

/// Acquires a lock that is held only briefly, unless its holder has crashed or waits for a reader. In that case it
/// gives up. (A timed mutex would do, but ThreadSanitizer of GCC 12 does not know its calls.)
std::unique_lock<std::mutex> tryToLock(std::mutex& mutex) {
  constexpr int kTries = 100;
  std::unique_lock lock(mutex, std::try_to_lock);
  for (int i = 0; i < kTries && !lock; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    static_cast<void>(lock.try_lock());  // the loop asks the lock itself
  }
  return lock;
}

void writeOut(const std::string& line) {
  for (std::size_t at = 0; at < line.size();) {
    const ssize_t written = ::write(STDERR_FILENO, line.data() + at, line.size() - at);
    if (written <= 0) return;  // nobody is left to read it
    at += static_cast<std::size_t>(written);
  }
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

int SharedText::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char letter = traits_type::to_char_type(c);
  return xsputn(&letter, 1) == 1 ? c : traits_type::eof();
}

std::streamsize SharedText::xsputn(const char* from, std::streamsize size) {
  const std::lock_guard lock(mMutex);
  mText.append(from, static_cast<std::size_t>(size));
  return size;
}

std::string SharedText::lines() {
  const std::unique_lock lock = tryToLock(mMutex);
  return lock ? mText.substr(0, mText.rfind('\n') + 1) : std::string();
}

int WarningLines::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  mLine += traits_type::to_char_type(c);
  if (mLine.ends_with('\n')) {
    if (mLine.starts_with("warning: ")) std::cerr << mLine;
    mLine.clear();
  }
  return c;
}

Report& report() {
  // Never destroyed, as the thread that waits for signals may still ask what is left while the process ends.
  static Report& theReport = *new Report;
  return theReport;
}

void Report::start(std::string command, bool json) {
  const std::lock_guard order(mWriting);
  std::unique_lock lock(mMutex);
  mCommand = std::move(command);
  mJson = json;
  if (!json) return;
  const std::string line = lineOf({{"event", "start"}, {"version", JULIAVDB_VERSION}, {"share", mShare}});
  lock.unlock();
  writeOut(line);
}

std::ostream& Report::text() { return mJson ? mText : mTalk == Talk::Quiet ? mWarnings : std::cerr; }

void Report::keep(const std::string& name, Number value) {
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

void Report::noteKept(std::string what) {
  const std::lock_guard lock(mMutex);
  mKept = std::move(what);
}

std::string Report::whatIsLeft() {
  const std::unique_lock lock = tryToLock(mMutex);
  if (!lock) return {};
  if (!mKept.empty()) return mKept;
  if (mWritten.empty()) return {};
  constexpr std::size_t kNamed = 4;
  std::string text = mWritten.size() == 1 ? "this file is finished: " : "these files are finished: ";
  for (std::size_t i = 0; i < std::min(kNamed, mWritten.size()); ++i) text += (i == 0 ? "" : ", ") + mWritten[i];
  if (mWritten.size() > kNamed) text += " and " + std::to_string(mWritten.size() - kNamed) + " more";
  return text;
}

void Report::phaseEnded(const std::string& phase, double wall, double cpu, double share) {
  const std::unique_lock order = mJson ? std::unique_lock(mWriting) : std::unique_lock<std::mutex>();
  std::unique_lock lock(mMutex);
  if (mEnded) return;
  const auto same = [&](const Phase& other) { return other.name == phase; };
  auto known = std::find_if(mPhases.begin(), mPhases.end(), same);
  if (known == mPhases.end()) known = mPhases.insert(known, {phase, 0, 0});
  known->wall += wall;
  known->cpu += cpu;
  mShare = std::max(mShare, share);
  if (!mJson) return;
  const std::string line =
      lineOf({{"event", "phase"}, {"phase", phase}, {"wall", wall}, {"cpu", cpu}, {"share", mShare}});
  lock.unlock();
  writeOut(line);
}

void Report::progress(nlohmann::json progress, double share) {
  const std::lock_guard order(mWriting);
  std::unique_lock lock(mMutex);
  if (mEnded) return;
  mShare = std::max(mShare, share);
  progress["event"] = "progress";
  progress["share"] = mShare;
  const std::string line = lineOf(std::move(progress));
  lock.unlock();
  writeOut(line);
}

void Report::end(int exitCode, const std::string& error) {
  // Its holder may be waiting for a reader of stderr that is gone; an interruption does not wait for that.
  const std::unique_lock order = tryToLock(mWriting);
  std::unique_lock lock = tryToLock(mMutex);
  if (!lock || mEnded) return;  // a thread that has crashed with it prints nothing any more
  mEnded = true;
  if (!mJson) {
    if (mTalk == Talk::Verbose) std::cerr << whatItTook();
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
                       {"messages", linesOf(mSentences.lines())}};
  if (!error.empty()) event["error"] = error;
  for (const auto& [name, value] : mCounts)
    event["counts"][name] = std::visit([](auto number) { return jsonOf(number); }, value);
  for (const Phase& phase : mPhases)
    event["phases"].push_back({{"phase", phase.name}, {"wall", phase.wall}, {"cpu", phase.cpu}});
  const std::string line = lineOf(std::move(event));
  lock.unlock();
  writeOut(line);
}

double Report::wallSeconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - mStart).count();
}

double Report::cpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string Report::whatItTook() const {
  std::ostringstream text;
  const auto seconds = [&](double wall, double cpu) {
    text << vdbtools::shortText(wall) << " s, " << vdbtools::shortText(cpu) << " s of CPU time";
  };
  for (const Phase& phase : mPhases) {
    text << phase.name << ": ";
    seconds(phase.wall, phase.cpu);
    text << '\n';
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  text << "in all: ";
  seconds(wallSeconds(), cpuSeconds());
  text << ", at most " << vdbtools::memoryText(1024.0 * static_cast<double>(usage.ru_maxrss)) << " of memory\n";
  return std::move(text).str();
}

std::string Report::lineOf(nlohmann::json event) const {
  event["command"] = mCommand;
  event["elapsed"] = wallSeconds();
  if (!mMaking.empty()) event["file"] = mMaking.front();
  if (mMaking.size() > 1) event["files"] = mMaking;
  // Names of files need not be UTF-8, but JSON is.
  return event.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace cli
