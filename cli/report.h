// SPDX-License-Identifier: Apache-2.0
/// @file report.h
/// What the program says on stderr: sentences, or with --progress json nothing but JSON objects, one a line. The fields
/// of those are described in docs/progress.md. The work says things and the watcher of interruption.h may say the last
/// one at any moment, so all of this may be called from any thread; but only the work uses text().
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <ostream>
#include <streambuf>
#include <string>
#include <utility>
#include <vector>

namespace cli {

/// Keeps what is written, for another thread to read it.
class SharedText final : public std::streambuf {
 public:
  /// The whole lines. @return nothing if the lock is not to be had: its holder has crashed
  std::string lines();

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* from, std::streamsize size) override;

 private:
  std::mutex mMutex;
  std::string mText;
};

class Report {
 public:
  /// Call once, before the work. @param command  the first word of the command line, if there is one
  void start(std::string command, bool json);
  bool json() const { return mJson; }

  /// For the sentences of a command that has done its work. As JSON they wait for the closing event.
  std::ostream& text();
  /// A number of the summary, such as that of the triangles.
  void count(const std::string& name, double value);

  /// A file is being made. @param first  whether it is the first of those that appear together
  void making(const std::filesystem::path& file, bool first);
  /// A file is in its place.
  void wrote(const std::filesystem::path& file);
  /// From now on, this is what an interruption leaves, such as "finished frames are kept".
  void noteKept(std::string what);
  /// What an interruption would leave now: that, or the files that are in their places; empty: none that is known here.
  std::string whatIsLeft();

  /// A phase is over: what it took, in seconds.
  void phaseEnded(const std::string& phase, double wall, double cpu, double share);
  /// Says where the work is, as JSON. @param progress  the fields that the watcher of the phase adds
  void progress(nlohmann::json progress, double share);

  /// The last thing that is said: of a failure one line, or as JSON the closing event. Only the first call counts.
  /// @param error  empty if all went well
  void end(int exitCode, const std::string& error);

  double wallSeconds() const;
  static double cpuSeconds();  ///< of all threads

 private:
  struct Phase {
    std::string name;
    double wall, cpu;
  };

  /// The event as a line. Call with mMutex held.
  std::string lineOf(nlohmann::json event) const;

  const std::chrono::steady_clock::time_point mStart = std::chrono::steady_clock::now();
  std::atomic<bool> mJson{false};
  SharedText mSentences;
  std::ostream mText{&mSentences};
  // The order of lines. Who holds it may wait for a reader of stderr for ever. Take it before the other one.
  std::mutex mWriting;
  std::mutex mMutex;  // of everything below; held for a moment only
  std::string mCommand;
  std::vector<std::string> mMaking, mWritten;
  std::string mKept;
  std::vector<std::pair<std::string, double>> mCounts;
  std::vector<Phase> mPhases;
  double mShare = 0;
  bool mEnded = false;
};

/// The one of this process.
Report& report();

}  // namespace cli
