// SPDX-License-Identifier: Apache-2.0
/// @file report.h
/// What the program says on stderr: sentences, or with --progress json nothing but JSON objects, one a line. The fields
/// of those are described in docs/progress.md.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <filesystem>
#include <iosfwd>
#include <mutex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace cli {

class Report {
 public:
  /// Call once, before the work. @param command  the first word of the command line, if there is one
  void start(std::string command, bool json);
  bool json() const { return mJson; }
  const std::string& command() const { return mCommand; }

  /// For the sentences of a command that has done its work. As JSON they wait for the closing event.
  std::ostream& text();
  /// A number of the summary, such as that of the triangles.
  void count(const std::string& name, double value);

  /// A file is being made. @param first  whether it is the first of those that appear together
  void making(const std::filesystem::path& file, bool first);
  /// A file is in its place.
  void wrote(const std::filesystem::path& file);

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
  void write(nlohmann::json event);

  struct Phase {
    std::string name;
    double wall, cpu;
  };

  std::string mCommand;
  bool mJson = false;
  std::chrono::steady_clock::time_point mStart = std::chrono::steady_clock::now();
  std::ostringstream mText;
  std::timed_mutex mMutex;  // of everything below, and of the order of lines
  std::vector<std::string> mMaking, mWritten;
  std::vector<std::pair<std::string, double>> mCounts;
  std::vector<Phase> mPhases;
  double mShare = 0;
  bool mEnded = false;
};

/// The one of this process.
Report& report();

}  // namespace cli
