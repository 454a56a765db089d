// SPDX-License-Identifier: Apache-2.0
/// @file task.h
/// Runs one task of a plan and records it in a side-car, by which it is checked later.
///
/// A side-car is DIR/tasks/0007.json, written after the task's files are committed. It has the task's hash and, for
/// each file, its size and SHA-256. A task whose side-car does not match its files or its plan is not done.
/// DIR/tasks/0007.running.json exists while a task runs, and DIR/tasks/0007.failed.json after a failure.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/files/input_files.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools::farm {

/// What the maker of a task returns after committing its files.
struct TaskCounts {
  std::map<std::string, std::uint64_t> counts;  ///< "triangles", "points", "evaluatedNodes" and the like
  std::vector<std::string> warnings;            ///< what whoever runs the task should know, one line each
};

struct TaskFile {
  std::string name;  ///< relative to the folder of the plan
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  ///< modification time of the file, in nanoseconds since 1970
  std::string sha256;
};

/// The content of a side-car.
struct TaskRecord {
  std::string hash;             ///< taskHash()
  std::vector<TaskFile> files;  ///< in the order of PlannedTask::writes
  std::map<std::string, std::uint64_t> counts;
  double wallSeconds = 0, cpuSeconds = 0;
  std::uint64_t peakBytes = 0;  ///< peak of the whole process while it ran the task
  std::string host;
  int threads = 0;
};

enum class FileCheck {
  Quick,    ///< by size and time; by SHA-256 if the time has changed
  Content,  ///< by SHA-256
};

/// The sum of what two tasks, or groups of tasks, have counted.
/// @throw DataError  it does not fit into 64 bits
std::uint64_t sumOfCounts(std::uint64_t a, std::uint64_t b);

/// Returns the record of task @a index if its side-car matches the plan and the files.
std::optional<TaskRecord> finishedTask(const std::filesystem::path& folder, const Manifest& manifest,
                                       std::uint64_t index, FileCheck check);

enum class TaskState { Done, Running, Failed, Missing };

struct TaskStatus {
  TaskState state = TaskState::Missing;
  std::optional<TaskRecord> record;  ///< for Done
  std::string error;                 ///< for Failed: what happened, in one line
  std::optional<int> exitCode{};     ///< for Failed: the exit code of the failed program, if it is recorded
  std::optional<std::filesystem::file_time_type> failedAt{};  ///< for a recorded failure
};

/// Does not change anything on the disk. A running task whose process was killed counts as missing: immediately if file
/// locks reach all machines, else a minute after its last sign of life.
TaskStatus taskStatus(const std::filesystem::path& folder, const Manifest& manifest, std::uint64_t index,
                      FileCheck check);

/// @throw DataError          an input is not the one with which the plan was made
/// @throw MissingInputError  an input does not exist any more
void requireInputs(const std::filesystem::path& folder, const Manifest& manifest);

/// The files of a plan and those that its recipe names; merged outputs must not replace them.
/// @throw as parseFractalOptions() of its recipe
InputFiles planInputs(const std::filesystem::path& folder, const Manifest& manifest);

/// Removes what killed processes have left in the folders of a plan: temporary files, and marks of running tasks.
void sweepPlan(const std::filesystem::path& folder, const Manifest& manifest);

/// Removes what no task of the plan needs any more, such as the distances of its targets once all of their tasks are
/// done. A task that is run again makes them again.
void removeUnneeded(const std::filesystem::path& folder, const Manifest& manifest);

/// Makes the files of a task, each whole or not at all.
using TaskMaker =
    std::function<TaskCounts(const std::filesystem::path&, const Manifest&, std::uint64_t index, Monitor&)>;

/// Returns a maker that runs the tasks of one plan one after another and makes what they share only once.
/// @throw what the job of its kind throws
TaskMaker makerOf(const std::filesystem::path& folder, const Manifest& manifest);

/// Runs the tasks of one plan, one at a time. Other processes may run the same tasks of the same plan at the same time:
/// each file appears as a whole, and all have the same bytes.
class TaskRunner {
 public:
  /// @param maker  by default makerOf() the plan
  /// @throw as readManifest()
  explicit TaskRunner(std::filesystem::path folder, TaskMaker maker = {});

  const Manifest& manifest() const { return mManifest; }

  /// Makes the task's files and writes its side-car; then removes what no task needs any more. Before the first task,
  /// it sweeps the folder and checks the inputs; it sweeps again where the last time is kSweepInterval ago. An
  /// interruption leaves the task missing.
  /// @param warn  takes the warnings of what was made
  /// @return false if the task was already done
  /// @throw as requireInputs(), AtomicFile and the maker; std::out_of_range
  bool run(std::uint64_t index, Monitor& monitor, const std::function<void(const std::string&)>& warn = {});

  /// Records that a task has failed, if the disk permits. @param error  one line
  void recordFailure(std::uint64_t index, int exitCode, const std::string& error) const noexcept;

  /// Sweeping lists whole folders, which is too much for each of many small tasks.
  static constexpr std::chrono::seconds kSweepInterval{10};

 private:
  void sweep();

  std::filesystem::path mFolder;
  TaskMaker mMaker;
  Manifest mManifest;
  std::optional<std::chrono::steady_clock::time_point> mSwept;  ///< when it last did
  bool mInputsChecked = false;
};

/// "0007".
std::string taskName(std::uint64_t index);

/// Ascending numbers in the notation of Slurm's arrays: "3,7,10-12".
std::string taskList(const std::vector<std::uint64_t>& indices);

}  // namespace vdbtools::farm
