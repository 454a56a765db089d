// SPDX-License-Identifier: Apache-2.0
/// @file report.h
/// What the program prints on stderr: sentences, or with --progress json only JSON objects, one per line, with the
/// fields described in docs/progress.md. The thread that watches for interruption (interruption.h) may print the last
/// message at any moment, so any thread may call these functions; but only the work uses text().
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <atomic>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <ostream>
#include <streambuf>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace cli {

/// Stores written text so that another thread can read it.
class SharedText final : public std::streambuf {
 public:
  /// Returns the complete lines, or an empty text if the lock cannot be acquired because its holder has crashed.
  std::string lines();

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* from, std::streamsize size) override;

 private:
  std::mutex mMutex;
  std::string mText;
};

/// Passes on the lines that are warnings, and swallows the others.
class WarningLines final : public std::streambuf {
 protected:
  int_type overflow(int_type c) override;

 private:
  std::string mLine;
};

/// Which sentences are printed: warnings alone, all, or also what the work took.
enum class Talk { Quiet, Usual, Verbose };

class Report {
 public:
  /// Call once, before the work. @param command  the first word of the command line, if there is one
  void start(std::string command, bool json);
  bool json() const { return mJson; }
  /// Call it before the first sentence. @pre  not in JSON mode
  void setTalk(Talk talk) { mTalk = talk; }

  /// The stream for the sentences of a command that has finished its work. In JSON mode they wait for the closing
  /// event.
  std::ostream& text();
  /// A number of the summary, such as the number of triangles. A later call with the same name replaces it.
  void count(const std::string& name, double value) { keep(name, value); }
  /// Whole numbers keep all their digits.
  template <std::integral Whole>
  void count(const std::string& name, Whole value) {
    keep(name, std::conditional_t<std::is_signed_v<Whole>, std::int64_t, std::uint64_t>{value});
  }

  /// Announces a file that is being made. @param first  whether it is the first of the files that appear together
  void making(const std::filesystem::path& file, bool first);
  /// Announces a committed file.
  void wrote(const std::filesystem::path& file);
  /// Sets what an interruption leaves behind from now on, such as "finished frames are kept".
  void noteKept(std::string what);
  /// What an interruption would leave behind now: the text of noteKept(), or the committed files; empty: none known
  /// here.
  std::string whatIsLeft();

  /// Reports the end of a phase and the time that it took, in seconds.
  void phaseEnded(const std::string& phase, double wall, double cpu, double share);
  /// Reports the progress as JSON. @param progress  the fields that the watcher of the phase adds
  void progress(nlohmann::json progress, double share);

  /// Prints the final message: one line for a failure, or the closing event in JSON mode. Only the first call counts.
  /// @param error  empty if there was no failure
  void end(int exitCode, const std::string& error);

  double wallSeconds() const;
  static double cpuSeconds();  ///< of all threads

 private:
  struct Phase {
    std::string name;
    double wall, cpu;
  };

  using Number = std::variant<double, std::int64_t, std::uint64_t>;
  void keep(const std::string& name, Number value);

  /// The event as a line. mMutex must be held.
  std::string lineOf(nlohmann::json event) const;

  const std::chrono::steady_clock::time_point mStart = std::chrono::steady_clock::now();
  /// How long each phase took, and the process as a whole. mMutex must be held.
  std::string whatItTook() const;

  std::atomic<bool> mJson{false};
  std::atomic<Talk> mTalk{Talk::Usual};
  WarningLines mWarningLines;
  std::ostream mWarnings{&mWarningLines};
  SharedText mSentences;
  std::ostream mText{&mSentences};
  // Keeps the order of lines. Its holder may block forever on a reader of stderr. Lock it before the other mutex.
  std::mutex mWriting;
  std::mutex mMutex;  // guards everything below; held only briefly
  std::string mCommand;
  std::vector<std::string> mMaking, mWritten;
  std::string mKept;
  std::vector<std::pair<std::string, Number>> mCounts;
  std::vector<Phase> mPhases;
  double mShare = 0;
  bool mEnded = false;
};

/// The report of this process.
Report& report();

}  // namespace cli
