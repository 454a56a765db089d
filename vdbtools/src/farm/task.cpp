// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/task.h"

#include "base/threads.h"
#include "farm/target_store.h"
#include "farm/task_files.h"
#include "farm/tile_task.h"
#include "farm/variant_task.h"

#include "files/mark_file.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/scene.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

/// The mark of a running task, with a thread that touches it as a sign of life.
class RunningMark {
 public:
  RunningMark(const fs::path& path, const std::string& content) : mFile(path, content) {
    mThread = std::thread([this] {
      std::unique_lock lock(mMutex);
      while (!mWake.wait_for(lock, kSignOfLife, [this] { return mEnds; })) mFile.touch();
    });
  }
  RunningMark(const RunningMark&) = delete;
  RunningMark& operator=(const RunningMark&) = delete;
  ~RunningMark() {
    {
      const std::lock_guard lock(mMutex);
      mEnds = true;
    }
    mWake.notify_one();
    mThread.join();
  }

 private:
  MarkFile mFile;
  std::mutex mMutex;
  std::condition_variable mWake;
  bool mEnds = false;  // guarded by mMutex
  std::thread mThread;
};

double cpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Resets the peak memory for another task, if Linux allows the process to do so.
void forgetPeak() { std::ofstream("/proc/self/clear_refs") << "5\n"; }

/// The peak memory since forgetPeak().
std::uint64_t peakBytes() {
  constexpr std::uint64_t kUnit = 1024;
  constexpr std::string_view kEntry = "VmHWM:";
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(kEntry)) return kUnit * std::strtoull(line.c_str() + kEntry.size(), nullptr, 10);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return kUnit * static_cast<std::uint64_t>(usage.ru_maxrss);
}

/// The folders to which a plan's tasks write.
std::set<fs::path> foldersOf(const fs::path& folder, const Manifest& manifest) {
  std::set<fs::path> folders = {folder, tasksFolder(folder), folder / kTargetsName};
  for (const PlannedTask& task : manifest.tasks)
    for (const std::string& name : task.writes) folders.insert((folder / name).parent_path());
  return folders;
}

void createFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw CreateError("cannot create the folder " + inOneLine(folder.native()) + ": " + error.message());
}

TaskFile fileRecord(const fs::path& folder, const std::string& name) {
  const fs::path path = folder / name;
  std::optional<TaskFile> file = presentFile(path);
  if (!file) throw std::logic_error("a task was made, but not its file " + inOneLine(path.native()));
  file->name = name;
  file->sha256 = sha256OfFile(path);
  return *std::move(file);
}

}  // namespace

TaskMaker makerOf(const fs::path& folder, const Manifest& manifest) {
  switch (manifest.kind) {
    case PlanKind::Tiles:
      return [maker = std::make_shared<TileMaker>(folder, manifest)](const fs::path&, const Manifest&,
                                                                     std::uint64_t index, Monitor& monitor) {
        return maker->make(index, monitor);
      };
    case PlanKind::Frames:
    case PlanKind::Sheet:
      return [maker = std::make_shared<VariantMaker>(folder, manifest)](const fs::path&, const Manifest&,
                                                                        std::uint64_t index, Monitor& monitor) {
        return maker->make(index, monitor);
      };
  }
  throw std::logic_error("a kind of plan has no maker of its tasks");
}

void removeUnneeded(const fs::path& folder, const Manifest& manifest) {
  if (manifest.kind != PlanKind::Tiles) removeUnneededTargets(folder, manifest);
}

void requireInputs(const fs::path& folder, const Manifest& manifest) {
  for (const PlannedInput& input : manifest.inputs) {
    const fs::path path = folder / input.path;
    const std::string found = sha256OfFile(path);
    if (found != input.sha256)
      throw DataError("'" + inOneLine(path.native()) +
                      "' is not the file that the plan was made with: its SHA-256 is " + found + " and was " +
                      input.sha256 + "; restore it, or plan again");
  }
}

InputFiles planInputs(const fs::path& folder, const Manifest& manifest) {
  InputFiles inputs;
  if (manifest.kind == PlanKind::Tiles) inputs.add(inputsOf(parseFractalOptions(manifest.recipe)));
  inputs.add(folder / kManifestName);
  for (const PlannedInput& input : manifest.inputs) inputs.add(folder / input.path);
  for (const fs::path& place : foldersOf(folder, manifest))
    if (place != folder) inputs.addFolder(place);
  inputs.addFolder(folder / kLogsName);
  return withRecordedFiles(std::move(inputs));
}

void sweepPlan(const fs::path& folder, const Manifest& manifest) {
  for (const fs::path& place : foldersOf(folder, manifest)) sweepTemporaries(place);
  std::error_code error;
  const fs::directory_iterator end;
  for (fs::directory_iterator entry(tasksFolder(folder), error); !error && entry != end; entry.increment(error))
    if (entry->path().native().ends_with(kRunningSuffix)) removeDeadMark(entry->path());
}

TaskRunner::TaskRunner(fs::path folder, TaskMaker maker)
    : mFolder(std::move(folder)), mMaker(std::move(maker)), mManifest(readManifest(mFolder)) {
  if (!mMaker) mMaker = makerOf(mFolder, mManifest);
}

void TaskRunner::sweep() {
  if (mSwept && Clock::now() - *mSwept < kSweepInterval) return;
  sweepPlan(mFolder, mManifest);
  mSwept = Clock::now();
}

bool TaskRunner::run(std::uint64_t index, Monitor& monitor, const std::function<void(const std::string&)>& warn) {
  TaskRecord record;
  record.hash = taskHash(mManifest, index);
  // Also if nothing is to be made: another process with the same task may have been killed.
  sweep();
  if (finishedTask(mFolder, mManifest, index, FileCheck::Content)) {
    removeUnneeded(mFolder, mManifest);
    return false;
  }
  createFolder(tasksFolder(mFolder));
  for (const std::string& name : mManifest.tasks[index - 1].writes) createFolder((mFolder / name).parent_path());

  const RunningMark mark(runningPath(mFolder, index), encodeRunning(index));
  std::error_code ignored;
  fs::remove(failedPath(mFolder, index), ignored);
  if (!mInputsChecked) {
    monitor.begin(PhaseKind::Checking, 0);
    requireInputs(mFolder, mManifest);
    mInputsChecked = true;
  }

  forgetPeak();
  const Clock::time_point start = Clock::now();
  const double cpuStart = cpuSeconds();
  TaskCounts made = mMaker(mFolder, mManifest, index, monitor);
  record.counts = std::move(made.counts);
  monitor.begin(PhaseKind::Checking, 0);
  for (const std::string& name : mManifest.tasks[index - 1].writes) record.files.push_back(fileRecord(mFolder, name));
  record.wallSeconds = std::chrono::duration<double>(Clock::now() - start).count();
  record.cpuSeconds = cpuSeconds() - cpuStart;
  record.peakBytes = peakBytes();
  record.host = hostName();
  record.threads = allowedThreads();
  AtomicFile sideCar(sideCarPath(mFolder, index));
  sideCar.stream() << encodeRecord(index, record);
  sideCar.commit();
  removeUnneeded(mFolder, mManifest);
  if (warn)
    for (const std::string& warning : made.warnings) warn(warning);
  return true;
}

void TaskRunner::recordFailure(std::uint64_t index, int exitCode, const std::string& error) const noexcept {
  try {
    // Another process may have made it meanwhile.
    if (finishedTask(mFolder, mManifest, index, FileCheck::Quick)) return;
    createFolder(tasksFolder(mFolder));
    AtomicFile file(failedPath(mFolder, index));
    file.stream() << encodeFailure(index, taskHash(mManifest, index), exitCode, error);
    file.commit();
  } catch (const std::exception&) {
    // The failure itself is reported; without this note the task counts as missing.
  }
}

}  // namespace vdbtools::farm
