// SPDX-License-Identifier: Apache-2.0
/// @file task.h
/// One task of a plan: made, recorded by a side-car, and judged by it later.
///
/// A side-car is DIR/tasks/0007.json, written after the task's files are in their places. It has the task's hash and,
/// for each file, its size and SHA-256. A task whose side-car does not fit its files or its plan is not done.
/// While a task is being made there is DIR/tasks/0007.running.json, and after a failure DIR/tasks/0007.failed.json.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/files/input_files.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools::farm {

/// What the maker of a task gives back, its files being in their places.
struct TaskCounts {
  std::map<std::string, double> counts;  ///< "triangles", "points", "evaluatedNodes" and the like
};

struct TaskFile {
  std::string name;  ///< relative to the folder of the plan
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  ///< the file's time, in nanoseconds since 1970
  std::string sha256;
};

/// What a side-car holds.
struct TaskRecord {
  std::string hash;             ///< taskHash()
  std::vector<TaskFile> files;  ///< in the order of PlannedTask::writes
  std::map<std::string, double> counts;
  double wallSeconds = 0, cpuSeconds = 0;
  std::uint64_t peakBytes = 0;  ///< of the whole process while it made the task
  std::string host;
  int threads = 0;
};

enum class FileCheck {
  Quick,    ///< by size and time; by SHA-256 where the time has changed
  Content,  ///< by SHA-256
};

/// The record of task @a index if its side-car fits the plan and the files.
std::optional<TaskRecord> finishedTask(const std::filesystem::path& folder, const Manifest& manifest,
                                       std::uint64_t index, FileCheck check);

enum class TaskState { Done, Running, Failed, Missing };

struct TaskStatus {
  TaskState state = TaskState::Missing;
  std::optional<TaskRecord> record;  ///< of Done
  std::string error;                 ///< of Failed: what happened, in one line
  std::optional<int> exitCode{};     ///< of Failed: what the program that failed ended with, if that is recorded
  std::optional<std::filesystem::file_time_type> failedAt{};  ///< of a failure that is recorded
};

/// Changes nothing on the disk. A running task whose process was killed is missing: at once where locks of files reach
/// all machines, else a minute after its last sign of life.
TaskStatus taskStatus(const std::filesystem::path& folder, const Manifest& manifest, std::uint64_t index,
                      FileCheck check);

/// @throw DataError          an input is not the one that the plan was made with
/// @throw MissingInputError  an input is gone
void requireInputs(const std::filesystem::path& folder, const Manifest& manifest);

/// The files of a plan and those that its recipe names, which nothing that is merged may replace.
/// @throw as parseFractalOptions() of its recipe
InputFiles planInputs(const std::filesystem::path& folder, const Manifest& manifest);

/// Removes what killed processes have left in the folders of a plan: temporary files, and marks of running tasks.
void sweepPlan(const std::filesystem::path& folder, const Manifest& manifest);

/// Removes what no task of the plan needs any more, such as the distances of its targets once all of their tasks are
/// done. A task that is made again makes them again.
void removeUnneeded(const std::filesystem::path& folder, const Manifest& manifest);

/// Makes the files of a task, each whole or not at all.
using TaskMaker =
    std::function<TaskCounts(const std::filesystem::path&, const Manifest&, std::uint64_t index, Monitor&)>;

/// Makes the tasks of one plan, one after another; what they share is made once.
/// @throw what the job of its kind throws
TaskMaker makerOf(const std::filesystem::path& folder, const Manifest& manifest);

/// Makes the tasks of one plan, one at a time. Others may make the same tasks of the same plan at the same time: each
/// file appears as a whole, and all have the same bytes.
class TaskRunner {
 public:
  /// @param maker  makerOf() the plan, unless another one is given
  /// @throw as readManifest()
  explicit TaskRunner(std::filesystem::path folder, TaskMaker maker = {});

  const Manifest& manifest() const { return mManifest; }

  /// Sweeps the folder, checks the inputs, makes the task's files and writes its side-car; then removes what no task
  /// needs any more. An interruption leaves the task missing.
  /// @return false if it was done already
  /// @throw as requireInputs(), AtomicFile and the maker; std::out_of_range
  bool run(std::uint64_t index, Monitor& monitor);

  /// Records that a task has failed, as far as the disk takes it. @param error  one line
  void recordFailure(std::uint64_t index, int exitCode, const std::string& error) const noexcept;

 private:
  std::filesystem::path mFolder;
  TaskMaker mMaker;
  Manifest mManifest;
  bool mInputsChecked = false;
};

/// "0007".
std::string taskName(std::uint64_t index);

/// Ascending numbers in the notation of Slurm's arrays: "3,7,10-12".
std::string taskList(const std::vector<std::uint64_t>& indices);

}  // namespace vdbtools::farm
