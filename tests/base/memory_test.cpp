// SPDX-License-Identifier: Apache-2.0
#include "support/temporary_folder.h"

#include "vdbtools/base/memory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

constexpr double kMiB = 1 << 20;

/// A machine in a folder.
class Memory : public ::testing::Test {
 protected:
  void file(const fs::path& path, const std::string& content) const {
    fs::create_directories((mRoot / path).parent_path());
    std::ofstream(mRoot / path) << content;
  }
  void machine(int availableMiB, int swapMiB = 0) const {
    file("proc/meminfo", "MemTotal: 9999999 kB\nMemAvailable: " + std::to_string(availableMiB * 1024) +
                             " kB\nSwapFree: " + std::to_string(swapMiB * 1024) + " kB\n");
  }
  void group(const fs::path& path, const std::string& max, int currentMiB, int ofFilesMiB = 0) const {
    const fs::path folder = "sys/fs/cgroup" / path;
    file(folder / "memory.max", max + "\n");
    file(folder / "memory.current", std::to_string(currentMiB * (1 << 20)) + "\n");
    file(folder / "memory.stat", "anon 1\ninactive_file " + std::to_string(ofFilesMiB * (1 << 20)) + "\n");
  }
  double leftMiB() const { return sharedMemoryLeft(mRoot).bytes / kMiB; }

  const TemporaryFolder mFolder;
  const fs::path mRoot = mFolder.path();
};

TEST_F(Memory, OfNothingIsUnlimited) { EXPECT_TRUE(std::isinf(sharedMemoryLeft(mRoot).bytes)); }

TEST_F(Memory, OfAMachineIsWhatIsAvailableAndItsSwapSpace) {
  machine(500, 70);
  EXPECT_EQ(leftMiB(), 570);
}

TEST_F(Memory, OfAGroupIsItsLimitLessWhatItUses) {
  machine(500);
  file("proc/self/cgroup", "0::/a/b\n");
  group("a/b", std::to_string(300 << 20), 120, 20);
  EXPECT_EQ(leftMiB(), 200);
  EXPECT_NE(sharedMemoryLeft(mRoot).limit.find("group"), std::string::npos);
}

// Promise: "Work that is known not to fit ..."
TEST_F(Memory, OfAGroupIsLimitedByThoseAboveIt) {
  machine(500);
  file("proc/self/cgroup", "0::/a/b\n");
  group("a/b", "max", 20);
  group("a", std::to_string(100 << 20), 60);
  EXPECT_EQ(leftMiB(), 40);
}

TEST_F(Memory, OfAGroupInAContainerIsThatOfTheMount) {
  machine(500);
  file("proc/self/cgroup", "0::/../../elsewhere\n");
  group(".", std::to_string(90 << 20), 50);
  EXPECT_EQ(leftMiB(), 40);
}

TEST_F(Memory, OfAGroupMayBeSwapped) {
  machine(500, 1000);
  file("proc/self/cgroup", "0::/a\n");
  group("a", std::to_string(100 << 20), 60);
  file("sys/fs/cgroup/a/memory.swap.max", std::to_string(30 << 20));
  file("sys/fs/cgroup/a/memory.swap.current", std::to_string(10 << 20));
  EXPECT_EQ(leftMiB(), 60);
}

TEST_F(Memory, OfAGroupOfTheFirstVersion) {
  machine(500);
  file("proc/self/cgroup", "5:cpu,cpuacct:/x\n4:memory:/a\n");
  file("sys/fs/cgroup/memory/a/memory.limit_in_bytes", std::to_string(100 << 20));
  file("sys/fs/cgroup/memory/a/memory.usage_in_bytes", std::to_string(70 << 20));
  EXPECT_EQ(leftMiB(), 30);
}

TEST_F(Memory, UsedBeyondALimitLeavesNothing) {
  file("proc/self/cgroup", "0::/\n");
  group(".", std::to_string(50 << 20), 80);
  EXPECT_EQ(leftMiB(), 0);
}

TEST(MemoryInAll, IsTheSmallestLimitAlsoOfAProcessThatHasMore) {
  const double unset = memoryInAll();
  EXPECT_GT(unset, residentMemory());
  const MemoryLimit wide(unset + 1e9);
  EXPECT_EQ(memoryInAll(), unset + 1e9);
  const MemoryLimit narrow(residentMemory() / 2);
  EXPECT_LT(memoryInAll(), residentMemory());
  EXPECT_EQ(memoryLeft().bytes, 0);
}

TEST(MemoryText, HasTheUnitOfItsSize) {
  EXPECT_EQ(memoryText(1.5 * 1024 * kMiB), "1.5 GiB");
  EXPECT_EQ(memoryText(7), "7 bytes");
}

// Promise: "Work that is known not to fit ..."
TEST(RequireMemory, RefusesWhatNoMachineHas) {
  try {
    requireMemory(1e18, MemoryUse::Field, "the field");
    FAIL() << "1e18 bytes were found";
  } catch (const std::bad_alloc& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("the field would take at least 888 PiB"), std::string::npos) << text;
  }
  EXPECT_NO_THROW(requireMemory(1, MemoryUse::Field, "a byte"));
}

}  // namespace
}  // namespace vdbtools
