// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/task.h"

#include "support/small_disk.h"
#include "support/temporary_folder.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;
using namespace farm;

void put(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

constexpr std::uint64_t kMany = std::uint64_t{1} << 60;

std::string contentOf(const PlannedTask& task, const std::string& name) {
  return "result of " + task.recipe.at("alpha") + " in " + name + "\n";
}

/// Writes each file of a task, in the way that a true maker does.
TaskCounts makeFiles(const fs::path& folder, const Manifest& manifest, std::uint64_t index, Monitor&) {
  const PlannedTask& task = manifest.tasks.at(index - 1);
  for (const std::string& name : task.writes) {
    AtomicFile file(folder / name);
    file.stream() << contentOf(task, name);
    file.commit();
  }
  // The second is more than a double holds with all digits.
  return {{{"triangles", 100 * index}, {"points", kMany + index}}};
}

class TaskTest : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kTasks = 3;

  void SetUp() override { plan(mFolder); }

  static Manifest planned(const fs::path& folder) {
    Manifest manifest;
    manifest.kind = PlanKind::Frames;
    manifest.makes = {"vdb", "ply"};
    manifest.metadata = {{"folder", "/"}};
    manifest.recipe = {{"input", "bunny.obj"}};
    manifest.inputs = {{"input.obj", sha256OfFile(folder / "input.obj")}};
    for (std::uint64_t k = 1; k <= kTasks; ++k) {
      const std::string stem = "out/b." + taskName(k);
      manifest.tasks.push_back({{{"alpha", std::to_string(10 * k)}}, {}, {stem + ".vdb", stem + ".ply"}});
    }
    return manifest;
  }

  static void plan(const fs::path& folder) {
    put(folder / "input.obj", "v 0 0 0\n");
    put(folder / kManifestName, encodeManifest(planned(folder)));
  }

  std::set<std::string> listing() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(mFolder))
      if (!entry.is_directory()) names.insert(fs::relative(entry.path(), mFolder).native());
    return names;
  }

  TaskState stateOf(std::uint64_t index, FileCheck check = FileCheck::Content) const {
    return taskStatus(mFolder, readManifest(mFolder), index, check).state;
  }

  /// Runs @a act in a process of its own, which is killed once it has written a byte to the pipe that it is given.
  void runKilled(const std::function<void(int pipe)>& act, const std::function<void()>& beforehand = {}) const {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      act(ends[1]);
      ::_exit(0);
    }
    char byte = 0;
    ASSERT_EQ(::read(ends[0], &byte, 1), 1);
    if (beforehand) beforehand();
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ::close(ends[0]);
    ::close(ends[1]);
    ASSERT_TRUE(WIFSIGNALED(status));
  }

  const TemporaryFolder mTemporary;
  const fs::path mFolder = mTemporary.path();
  Monitor mMonitor;
};

// Promise: "Counts have 64 bits everywhere: in the records ..."
TEST_F(TaskTest, IsDoneOnceItsFilesAndItsRecordAreThere) {
  EXPECT_EQ(stateOf(2), TaskState::Missing);
  TaskRunner runner(mFolder, makeFiles);
  EXPECT_TRUE(runner.run(2, mMonitor));
  EXPECT_EQ(stateOf(2), TaskState::Done);
  EXPECT_EQ(stateOf(2, FileCheck::Quick), TaskState::Done);
  EXPECT_EQ(stateOf(1), TaskState::Missing);
  EXPECT_EQ(listing(), (std::set<std::string>{"input.obj", "manifest.json", "out/b.0002.ply", "out/b.0002.vdb",
                                              "tasks/0002.json"}));
  const std::optional<TaskRecord> record = finishedTask(mFolder, runner.manifest(), 2, FileCheck::Content);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->counts.at("triangles"), 200u);
  EXPECT_EQ(record->counts.at("points"), kMany + 2);
  ASSERT_EQ(record->files.size(), 2u);
  EXPECT_EQ(record->files[1].sha256, sha256OfFile(mFolder / "out/b.0002.ply"));
  EXPECT_EQ(record->files[1].bytes, fs::file_size(mFolder / "out/b.0002.ply"));
  EXPECT_GE(record->wallSeconds, 0);
  EXPECT_GT(record->peakBytes, 0u);
  EXPECT_THROW(runner.run(0, mMonitor), std::out_of_range);
  EXPECT_THROW(runner.run(kTasks + 1, mMonitor), std::out_of_range);
}

TEST_F(TaskTest, IsNotMadeTwice) {
  TaskRunner(mFolder, makeFiles).run(1, mMonitor);
  const auto neverCalled = [](const fs::path&, const Manifest&, std::uint64_t, Monitor&) -> TaskCounts {
    throw std::logic_error("made again");
  };
  EXPECT_FALSE(TaskRunner(mFolder, neverCalled).run(1, mMonitor));
}

// Promise: "a task that is done is left ..."
TEST_F(TaskTest, IsMadeAgainIfItsRecordDoesNotFit) {
  const fs::path file = mFolder / "out/b.0001.vdb", sideCar = mFolder / "tasks/0001.json";
  const auto original = [&] { return readWholeFile(file); };
  const std::vector<std::pair<const char*, std::function<void()>>> damages = {
      {"a byte changed",
       [&] {
         std::string t = original();
         t[3] ^= 1;
         put(file, t);
       }},
      {"cut off", [&] { fs::resize_file(file, fs::file_size(file) - 1); }},
      {"gone", [&] { fs::remove(file); }},
      {"record broken", [&] { fs::resize_file(sideCar, fs::file_size(sideCar) / 2); }},
      {"record empty", [&] { put(sideCar, ""); }},
      {"record of another task", [&] {
         TaskRunner(mFolder, makeFiles).run(2, mMonitor);
         fs::copy_file(mFolder / "tasks/0002.json", sideCar, fs::copy_options::overwrite_existing);
       }}};
  for (const auto& [name, damage] : damages) {
    SCOPED_TRACE(name);
    TaskRunner(mFolder, makeFiles).run(1, mMonitor);
    ASSERT_EQ(stateOf(1, FileCheck::Quick), TaskState::Done);
    damage();
    EXPECT_EQ(stateOf(1), TaskState::Failed);
    EXPECT_EQ(stateOf(1, FileCheck::Quick), TaskState::Failed);
    TaskRunner runner(mFolder, makeFiles);
    EXPECT_TRUE(runner.run(1, mMonitor));
    EXPECT_EQ(stateOf(1), TaskState::Done);
    EXPECT_EQ(readWholeFile(file), contentOf(runner.manifest().tasks[0], "out/b.0001.vdb"));
  }
}

// Promise: "a task that is done is left ..."
TEST_F(TaskTest, ACopiedFolderIsStillDone) {
  TaskRunner(mFolder, makeFiles).run(1, mMonitor);
  fs::last_write_time(mFolder / "out/b.0001.vdb", fs::file_time_type::clock::now() - std::chrono::hours(5));
  EXPECT_EQ(stateOf(1, FileCheck::Quick), TaskState::Done);
}

TEST_F(TaskTest, AnotherPlanInTheSameFolderHasOtherTasks) {
  TaskRunner(mFolder, makeFiles).run(1, mMonitor);
  Manifest manifest = readManifest(mFolder);
  manifest.tasks[0].recipe["alpha"] = "77";
  put(mFolder / kManifestName, encodeManifest(manifest));
  EXPECT_EQ(stateOf(1), TaskState::Failed);
}

TEST_F(TaskTest, RefusesAnotherInputBeforeAnythingIsMade) {
  put(mFolder / "input.obj", "v 0 0 1\n");
  TaskRunner runner(mFolder, makeFiles);
  try {
    runner.run(1, mMonitor);
    FAIL() << "the input has changed";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("input.obj"), std::string::npos) << error.what();
  }
  EXPECT_EQ(listing(), (std::set<std::string>{"input.obj", "manifest.json"}));
}

TEST_F(TaskTest, AFailureIsRecordedAndForgottenOnceItIsDone) {
  TaskRunner runner(mFolder, makeFiles);
  runner.recordFailure(1, 65, "the surface is empty");
  const TaskStatus status = taskStatus(mFolder, runner.manifest(), 1, FileCheck::Quick);
  EXPECT_EQ(status.state, TaskState::Failed);
  EXPECT_NE(status.error.find("the surface is empty"), std::string::npos);
  EXPECT_NE(status.error.find("65"), std::string::npos);
  EXPECT_TRUE(runner.run(1, mMonitor));
  EXPECT_EQ(stateOf(1), TaskState::Done);
  EXPECT_EQ(listing().count("tasks/0001.failed.json"), 0u);
  runner.recordFailure(1, 65, "another process failed at it");
  EXPECT_EQ(listing().count("tasks/0001.failed.json"), 0u) << "a task that is done has not failed";
}

TEST_F(TaskTest, AnInterruptionLeavesItMissing) {
  TaskState within = TaskState::Missing;
  TaskRunner runner(mFolder, [&](const fs::path&, const Manifest&, std::uint64_t, Monitor&) -> TaskCounts {
    within = stateOf(1);
    throw Interrupted("interrupted");
  });
  EXPECT_THROW(runner.run(1, mMonitor), Interrupted);
  EXPECT_EQ(within, TaskState::Running);
  EXPECT_EQ(stateOf(1), TaskState::Missing);
  EXPECT_EQ(listing(), (std::set<std::string>{"input.obj", "manifest.json"}));
}

// Promise: "A process that dies can ..."
TEST_F(TaskTest, AKilledProcessLeavesItMissingAndTheNextSweepsUp) {
  const auto dieWithin = [&](int pipe) {
    TaskRunner runner(mFolder, [&](const fs::path& folder, const Manifest&, std::uint64_t, Monitor&) -> TaskCounts {
      AtomicFile file(folder / "out/b.0001.vdb");
      file.stream() << "half of it" << std::flush;
      [[maybe_unused]] const ssize_t written = ::write(pipe, "x", 1);
      ::pause();
      return {};
    });
    runner.run(1, mMonitor);
  };
  runKilled(dieWithin, [&] {
    EXPECT_EQ(stateOf(1), TaskState::Running);
    sweepPlan(mFolder, readManifest(mFolder));
    EXPECT_EQ(listing().size(), 4u) << "the manifest, the input, a temporary file, and the mark";
    EXPECT_EQ(stateOf(1), TaskState::Running);
  });
  EXPECT_EQ(stateOf(1), TaskState::Missing);
  EXPECT_EQ(listing().size(), 4u);
  TaskRunner(mFolder, makeFiles).run(2, mMonitor);
  EXPECT_EQ(listing(), (std::set<std::string>{"input.obj", "manifest.json", "out/b.0002.ply", "out/b.0002.vdb",
                                              "tasks/0002.json"}));
}

// Promise: "A process that dies can ..."
TEST_F(TaskTest, TwoAtTheSameTimeGiveOneResult) {
  const fs::path start = mFolder / "start";
  std::vector<pid_t> children;
  for (int k = 0; k < 4; ++k) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      int code = 1;
      try {
        while (!fs::exists(start)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        for (std::uint64_t index = 1; index <= kTasks; ++index) TaskRunner(mFolder, makeFiles).run(index, mMonitor);
        code = 0;
      } catch (const std::exception& error) {
        ::fprintf(stderr, "%s\n", error.what());
      }
      ::_exit(code);
    }
    children.push_back(child);
  }
  put(start, "");
  for (const pid_t child : children) {
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  for (std::uint64_t index = 1; index <= kTasks; ++index) EXPECT_EQ(stateOf(index), TaskState::Done);
  EXPECT_EQ(listing().size(), 3 + 3 * kTasks) << "manifest, input, start; and of each task two files and a record";
}

TEST_F(TaskTest, AFullDiskDoesNoDamage) {
  const SmallDisk disk(mFolder / "disk");
  if (!disk.isMounted()) GTEST_SKIP() << "cannot mount a small disk: " << disk.error();
  plan(mFolder / "disk");
  TaskRunner small(mFolder / "disk", makeFiles);
  EXPECT_TRUE(small.run(1, mMonitor));
  TaskRunner large(mFolder / "disk", [](const fs::path& folder, const Manifest&, std::uint64_t, Monitor&) {
    AtomicFile file(folder / "out/b.0002.vdb");
    file.stream() << std::string(100'000, 'x');
    file.commit();
    return TaskCounts();
  });
  EXPECT_THROW(large.run(2, mMonitor), IoError);
  large.recordFailure(2, 74, "the disk is full");
  const Manifest manifest = readManifest(mFolder / "disk");
  EXPECT_EQ(taskStatus(mFolder / "disk", manifest, 1, FileCheck::Content).state, TaskState::Done);
  EXPECT_EQ(taskStatus(mFolder / "disk", manifest, 2, FileCheck::Content).state, TaskState::Failed);
  EXPECT_TRUE(small.run(2, mMonitor));
  EXPECT_EQ(taskStatus(mFolder / "disk", manifest, 2, FileCheck::Content).state, TaskState::Done);
}

TEST(TaskList, IsTheNotationOfSlurm) {
  EXPECT_EQ(taskList({}), "");
  EXPECT_EQ(taskList({5}), "5");
  EXPECT_EQ(taskList({3, 7, 10, 11, 12}), "3,7,10-12");
  EXPECT_EQ(taskList({1, 2, 4, 5, 7}), "1-2,4-5,7");
  EXPECT_EQ(taskName(7), "0007");
  EXPECT_EQ(taskName(12345), "12345");
}

}  // namespace
}  // namespace vdbtools
