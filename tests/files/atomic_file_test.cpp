// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/atomic_file.h"

#include "support/small_disk.h"
#include "support/temporary_folder.h"

#include "files/mark_file.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/io_failure.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream) << path;
  return {std::istreambuf_iterator<char>(stream), {}};
}

void put(const fs::path& path, const std::string& content) { std::ofstream(path, std::ios::binary) << content; }

unsigned int modeOf(const fs::path& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0) << path;
  return status.st_mode & 07777;
}

template <class Error>
std::string messageOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return {};
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class AtomicFileTest : public ::testing::Test {
 protected:
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(mFolder)) found.push_back(entry.path().filename());
    std::sort(found.begin(), found.end());
    return found;
  }

  using Names = std::vector<std::string>;
  const TemporaryFolder mTemporary;
  const fs::path mFolder = mTemporary.path();
};

// Promise: Files are never half written: "Outputs ..."
// Promise of houdini.md: A reader "never sees half a frame"
TEST_F(AtomicFileTest, AppearsOnlyWhenCommitted) {
  const fs::path target = mFolder / "out.vdb";
  AtomicFile file(target);
  EXPECT_EQ(file.target(), target);
  EXPECT_EQ(file.temporaryPath().parent_path(), mFolder);
  EXPECT_TRUE(fs::exists(file.temporaryPath()));
  file.stream() << "new";
  file.finish();
  file.finish();
  EXPECT_FALSE(fs::exists(target));
  EXPECT_EQ(contentOf(file.temporaryPath()), "new");
  file.commit();
  EXPECT_EQ(contentOf(target), "new");
  EXPECT_EQ(names(), Names{"out.vdb"});
  EXPECT_TRUE(file.temporaryPath().empty());
  EXPECT_THROW(file.commit(), std::logic_error);
}

TEST_F(AtomicFileTest, LeavesTheOldContentUntilCommitted) {
  const fs::path target = mFolder / "out";
  put(target, "old");
  {
    AtomicFile file(target);
    file.stream() << "abandoned";
    file.finish();
    EXPECT_EQ(contentOf(target), "old");
  }
  EXPECT_EQ(contentOf(target), "old");
  EXPECT_EQ(names(), Names{"out"});
  AtomicFile file(target);
  file.stream() << "new";
  file.commit();
  EXPECT_EQ(contentOf(target), "new");
  EXPECT_EQ(names(), Names{"out"});
}

// Promise: "No temporary file stays behind"
TEST_F(AtomicFileTest, LeavesNothingBehindAnException) {
  try {
    AtomicFile file(mFolder / "out");
    file.stream() << std::string(3 << 20, 'x');
    throw std::runtime_error("work failed");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(names(), Names{});
}

TEST_F(AtomicFileTest, CanBeMoved) {
  std::ostream* stream = nullptr;
  {
    std::vector<AtomicFile> files;
    files.emplace_back(mFolder / "a");
    stream = &files[0].stream();
    files.emplace_back(mFolder / "b");
    *stream << "first";
    AtomicFile a = std::move(files[0]);
    EXPECT_THROW(files[0].stream(), std::logic_error);
    a.commit();
    files[0] = AtomicFile(mFolder / "c");
  }
  EXPECT_EQ(names(), Names{"a"});
  EXPECT_EQ(contentOf(mFolder / "a"), "first");
}

TEST_F(AtomicFileTest, WritesAndSeeksAsAFileStreamDoes) {
  // Random writes of sizes about the buffer's, to this stream and to one in memory.
  std::mt19937 random(4);
  std::string expected;
  AtomicFile file(mFolder / "out");
  std::ostream& stream = file.stream();
  std::size_t position = 0;
  for (int i = 0; i < 300; ++i) {
    const std::size_t size = random() % 4 == 0 ? random() % (3 << 20) : random() % 1000;
    const std::string block(size, static_cast<char>('a' + i % 26));
    if (i % 7 == 0 && !expected.empty()) {
      position = random() % expected.size();
      if (i % 2 == 0) {
        stream.seekp(static_cast<std::streamoff>(position));
      } else {
        stream.seekp(static_cast<std::streamoff>(position) - static_cast<std::streamoff>(expected.size()),
                     std::ios::end);
      }
      ASSERT_TRUE(stream);
    }
    if (i % 3 == 0) {
      stream.put('!');
      expected.resize(std::max(expected.size(), position + 1));
      expected[position++] = '!';
    }
    stream.write(block.data(), static_cast<std::streamsize>(size));
    expected.resize(std::max(expected.size(), position + size));
    std::copy(block.begin(), block.end(), expected.begin() + static_cast<std::ptrdiff_t>(position));
    position += size;
    ASSERT_EQ(stream.tellp(), static_cast<std::streamoff>(position)) << i;
  }
  stream.seekp(0, std::ios::end);
  EXPECT_EQ(stream.tellp(), static_cast<std::streamoff>(expected.size()));
  file.commit();
  EXPECT_TRUE(contentOf(mFolder / "out") == expected);
}

TEST_F(AtomicFileTest, RefusesToSeekBeforeTheBeginning) {
  AtomicFile file(mFolder / "out");
  file.stream() << "abc";
  file.stream().seekp(-1);
  EXPECT_TRUE(file.stream().fail());
  EXPECT_TRUE(contains(messageOf<IoError>([&] { file.finish(); }), "out"));
  file.stream().clear();
  file.stream().seekp(-4, std::ios::cur);
  EXPECT_TRUE(file.stream().fail());
  file.stream().clear();
  file.commit();
  EXPECT_EQ(contentOf(mFolder / "out"), "abc");
}

TEST_F(AtomicFileTest, TakesNoMoreOnceFinished) {
  AtomicFile file(mFolder / "out");
  file.stream() << "abc";
  file.finish();
  file.stream() << std::flush;
  EXPECT_TRUE(file.stream());
  file.stream() << 'd';
  EXPECT_TRUE(file.stream().bad());
  EXPECT_THROW(file.commit(), IoError);
}

TEST_F(AtomicFileTest, GivesTheUsualPermissions) {
  const mode_t old = ::umask(027);
  {
    AtomicFile file(mFolder / "new");
    file.commit();
  }
  EXPECT_EQ(modeOf(mFolder / "new"), 0640U);
  for (const mode_t mode : {0600, 0666, 0755, 0204}) {
    put(mFolder / "old", "old");
    ASSERT_EQ(::chmod((mFolder / "old").c_str(), mode), 0);
    AtomicFile file(mFolder / "old");
    EXPECT_EQ(modeOf(file.temporaryPath()), mode);
    file.commit();
    EXPECT_EQ(modeOf(mFolder / "old"), mode);
  }
  ::umask(old);
}

TEST_F(AtomicFileTest, RefusesPlacesThatCannotBeWritten) {
  put(mFolder / "file", "x");
  fs::create_directory(mFolder / "folder");
  fs::create_symlink("loop", mFolder / "loop");
  const fs::path places[] = {mFolder,
                             mFolder / "folder",
                             mFolder / "folder/",
                             mFolder / "absent" / "out",
                             mFolder / "absent/",
                             mFolder / "file" / "out",
                             mFolder / "loop",
                             mFolder / std::string(300, 'n'),
                             fs::path("/proc/out.vdb"),
                             fs::path()};
  for (const fs::path& place : places) {
    const std::string message = messageOf<CreateError>([&] { AtomicFile file(place); });
    EXPECT_TRUE(contains(message, place.native().substr(0, 200))) << message;
  }
  const std::string message = messageOf<CreateError>([&] { AtomicFile file(mFolder / "absent" / "out"); });
  EXPECT_TRUE(contains(message, "there is no folder " + (mFolder / "absent").native())) << message;
  EXPECT_TRUE(contains(message, "mkdir -p")) << message;
  EXPECT_EQ(names(), (Names{"file", "folder", "loop"}));
  EXPECT_EQ(contentOf(mFolder / "file"), "x");
}

TEST_F(AtomicFileTest, RespectsWriteProtection) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write whatever the permissions say";
  put(mFolder / "file", "x");
  fs::permissions(mFolder / "file", fs::perms::owner_read);
  EXPECT_THROW(AtomicFile file(mFolder / "file"), CreateError);
  fs::permissions(mFolder, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THROW(AtomicFile file(mFolder / "new"), CreateError);
  fs::permissions(mFolder, fs::perms::owner_all);
}

TEST_F(AtomicFileTest, RefusesToWriteOneFileTwiceAtOnce) {
  AtomicFile file(mFolder / "out");
  fs::create_symlink("out", mFolder / "link");
  for (const fs::path& same : {mFolder / "out", mFolder / "." / "out", mFolder / "link"}) {
    EXPECT_THROW(AtomicFile again(same), CreateError) << same;
  }
  file.commit();
  AtomicFile(mFolder / "out").commit();
}

TEST_F(AtomicFileTest, WritesThroughLinks) {
  fs::create_directory(mFolder / "sub");
  put(mFolder / "sub" / "real", "old");
  fs::create_symlink("sub/real", mFolder / "link");
  fs::create_symlink("link", mFolder / "second");
  fs::create_symlink("sub/new", mFolder / "dangling");
  for (const auto& [link, real] : {std::pair{"link", "sub/real"}, {"second", "sub/real"}, {"dangling", "sub/new"}}) {
    AtomicFile file(mFolder / link);
    EXPECT_EQ(file.temporaryPath().parent_path(), mFolder / "sub");
    file.stream() << "through " << link;
    file.commit();
    EXPECT_TRUE(fs::is_symlink(mFolder / link)) << link;
    EXPECT_FALSE(fs::is_symlink(mFolder / real)) << link;
    EXPECT_EQ(contentOf(mFolder / real), std::string("through ") + link);
  }
}

TEST_F(AtomicFileTest, StaysWhereItWasWhenTheWorkingFolderChanges) {
  const fs::path before = fs::current_path();
  fs::create_directory(mFolder / "elsewhere");
  fs::current_path(mFolder);
  {
    AtomicFile file("relative");
    fs::current_path(mFolder / "elsewhere");
    file.commit();
  }
  fs::current_path(before);
  EXPECT_EQ(names(), (Names{"elsewhere", "relative"}));
}

TEST_F(AtomicFileTest, TakesTheLongestNames) {
  const std::string name(255, 'n');
  AtomicFile file(mFolder / name);
  file.commit();
  EXPECT_EQ(names(), Names{name});
}

TEST_F(AtomicFileTest, ReportsAFullDevice) {
  {
    AtomicFile file("/dev/full");
    EXPECT_TRUE(file.temporaryPath().empty());
    file.stream() << "small";  // stays in the buffer
    EXPECT_TRUE(contains(messageOf<IoError>([&] { file.finish(); }), std::strerror(ENOSPC)));
    EXPECT_THROW(file.finish(), IoError);
    EXPECT_THROW(file.commit(), IoError);
  }
  AtomicFile file("/dev/full");
  file.stream() << std::string(2 << 20, 'x');
  EXPECT_TRUE(file.stream().bad());
  file.stream().clear();  // the error stays all the same
  file.stream() << 'x';
  EXPECT_TRUE(file.stream().bad());
  file.stream().clear();
  EXPECT_TRUE(contains(messageOf<IoError>([&] { file.commit(); }), std::strerror(ENOSPC)));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(AtomicFileTest, WritesToDevicesAndPipesDirectly) {
  AtomicFile null("/dev/null");
  null.stream() << "x";
  EXPECT_EQ(null.stream().tellp(), std::streampos(-1));
  null.stream().clear();
  null.commit();
  EXPECT_TRUE(fs::is_character_file("/dev/null"));

  const fs::path pipe = mFolder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  auto received = std::async(std::launch::async, [&] { return contentOf(pipe); });
  const std::string content(3000001, 'p');
  {
    AtomicFile file(pipe);
    file.stream() << content;
    file.commit();
  }
  EXPECT_TRUE(received.get() == content);
  EXPECT_EQ(names(), Names{"pipe"});
}

// Promise: Files are never half written: "Outputs ..."
TEST_F(AtomicFileTest, KeepsTheOldFileWhenTheDiskIsFull) {
  const fs::path folder = mFolder / "disk";
  SmallDisk disk(folder);
  if (!disk.isMounted()) GTEST_SKIP() << "no small file system can be mounted here: " << disk.error();
  put(folder / "out", "old");
  for (const std::size_t size : {std::size_t{100} << 10, std::size_t{3} << 20}) {
    AtomicFile file(folder / "out");
    file.stream() << std::string(size, 'x');
    const std::string message = messageOf<IoError>([&] { file.finish(); });
    EXPECT_TRUE(contains(message, std::strerror(ENOSPC)) && contains(message, "out")) << message;
    EXPECT_THROW(file.commit(), IoError);
    EXPECT_EQ(contentOf(folder / "out"), "old");
  }
  // The room is free again, and one full output spares all others.
  AtomicFile small(folder / "small"), large(folder / "large");
  small.stream() << "x";
  large.stream() << std::string(100 << 10, 'x');
  const std::array files{&small, &large};
  EXPECT_THROW(commitAll(files), IoError);
  EXPECT_FALSE(fs::exists(folder / "small"));
  EXPECT_FALSE(fs::exists(folder / "large"));
}

TEST_F(AtomicFileTest, ReportsAnErrorInTheMiddleOfAFile) {
  // The limit on the size of files gives an error that needs no mount.
  struct rlimit old {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  struct rlimit limit = old;
  limit.rlim_cur = 1500000;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  {
    AtomicFile file(mFolder / "out");
    for (int i = 0; i < 2000; ++i) file.stream() << std::string(1000, 'x');
    EXPECT_TRUE(contains(messageOf<IoError>([&] { file.commit(); }), std::strerror(EFBIG)));
  }
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(names(), Names{});
}

// Promise: Files are never half written: "Outputs ..."
TEST_F(AtomicFileTest, CommitsSeveralTogether) {
  put(mFolder / "a", "old a");
  AtomicFile a(mFolder / "a"), b(mFolder / "b"), null("/dev/null");
  a.stream() << "new a";
  b.stream() << "new b";
  const std::array files{&a, &b, &null};
  commitAll(files);
  EXPECT_EQ(names(), (Names{"a", "b"}));
  EXPECT_EQ(contentOf(mFolder / "a"), "new a");
  EXPECT_EQ(contentOf(mFolder / "b"), "new b");
  EXPECT_THROW(commitAll(files), std::logic_error);
  commitAll({});
}

// Promise: Files are never half written: "Outputs ..."
TEST_F(AtomicFileTest, UndoesTheFirstWhenALaterOneCannotBePlaced) {
  put(mFolder / "a", "old a");
  {
    AtomicFile a(mFolder / "a"), b(mFolder / "b"), c(mFolder / "c");
    a.stream() << "new a";
    b.stream() << "new b";
    fs::create_directory(mFolder / "c");  // now c has no place any more
    const std::array files{&a, &b, &c};
    EXPECT_TRUE(contains(messageOf<IoError>([&] { commitAll(files); }), "/c"));
    EXPECT_EQ(contentOf(mFolder / "a"), "old a");
    EXPECT_FALSE(fs::exists(mFolder / "b"));
    fs::remove(mFolder / "c");
    commitAll(files);  // nothing was lost
  }
  EXPECT_EQ(names(), (Names{"a", "b", "c"}));
  EXPECT_EQ(contentOf(mFolder / "a"), "new a");
  EXPECT_EQ(contentOf(mFolder / "b"), "new b");
}

TEST_F(AtomicFileTest, RefusesToCommitOneFileTwice) {
  AtomicFile a(mFolder / "a");
  for (const std::array<AtomicFile*, 2>& files : {std::array{&a, &a}, std::array<AtomicFile*, 2>{&a, nullptr}}) {
    EXPECT_THROW(commitAll(files), std::logic_error);
  }
  EXPECT_FALSE(fs::exists(mFolder / "a"));
}

TEST_F(AtomicFileTest, RemovesWhatIsLeftInTheLastMoment) {
  put(mFolder / "a", "old");
  AtomicFile a(mFolder / "a"), b(mFolder / "b"), c(mFolder / "c");
  c.commit();
  a.stream() << "new";
  removeTemporaries();
  removeTemporaries();
  EXPECT_EQ(names(), (Names{"a", "c"}));
  EXPECT_THROW(a.commit(), IoError);
  const std::array files{&b, &a};
  EXPECT_THROW(commitAll(files), IoError);
  EXPECT_EQ(names(), (Names{"a", "c"}));
  EXPECT_EQ(contentOf(mFolder / "a"), "old");
}

TEST_F(AtomicFileTest, MayBeCleanedUpFromAnotherThread) {
  for (int round = 0; round < 20; ++round) {
    auto remover = std::async(std::launch::async, [] {
      for (int i = 0; i < 50; ++i) removeTemporaries();
    });
    for (int i = 0; i < 20; ++i) {
      try {
        AtomicFile file(mFolder / "out");
        file.stream() << "whole";
        file.commit();
      } catch (const IoError&) {
      }
    }
    remover.get();
  }
  for (const std::string& name : names()) EXPECT_EQ(name, "out");
  AtomicFile(mFolder / "out").commit();
}

/// Starts a process that creates a temporary file for @a target and waits, until it is killed.
class Owner {
 public:
  explicit Owner(const fs::path& target) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    mProcess = ::fork();
    if (mProcess == 0) {
      AtomicFile file(target);
      file.stream() << "half";
      [[maybe_unused]] const ssize_t written = ::write(ends[1], "x", 1);
      ::pause();
      ::_exit(0);
    }
    ::close(ends[1]);
    char byte = 0;
    if (::read(ends[0], &byte, 1) != 1) throw std::runtime_error("the process did not come so far");
    ::close(ends[0]);
  }
  void kill() const {
    ::kill(mProcess, SIGKILL);
    ::waitpid(mProcess, nullptr, 0);
  }

 private:
  pid_t mProcess;
};

// Promise: "No temporary file stays behind"
TEST_F(AtomicFileTest, SweepsWhatKilledProcessesLeft) {
  put(mFolder / ".x.0123456.tmp", "a name that is none of ours");
  put(mFolder / "x.01234567.tmp", "nor this");
  put(mFolder / ".x.0123456G.tmp", "nor this");
  const auto count = [&] { return std::distance(fs::directory_iterator(mFolder), {}); };
  const Owner owner(mFolder / "x.vdb"), other(mFolder / "y.vdb");
  AtomicFile own(mFolder / "z.vdb");
  own.stream() << "whole";
  own.finish();  // its bytes are on the disk, but it is not in its place
  EXPECT_EQ(count(), 6);
  EXPECT_EQ(sweepTemporaries(mFolder), 0u) << "all owners live";
  owner.kill();
  EXPECT_EQ(sweepTemporaries(mFolder), 1u);
  EXPECT_EQ(count(), 5);
  other.kill();
  EXPECT_EQ(sweepTemporaries(mFolder), 1u);
  EXPECT_EQ(sweepTemporaries(mFolder), 0u);
  own.commit();
  EXPECT_EQ(contentOf(mFolder / "z.vdb"), "whole");
  EXPECT_EQ(count(), 4);
  EXPECT_EQ(sweepTemporaries(mFolder / "nowhere"), 0u);
}

TEST_F(AtomicFileTest, RemovesWhatAKilledWriterOfTheSameFileLeft) {
  const std::string longName(200, 'n');
  for (const std::string& name : {std::string("x.vdb"), longName + "1.vdb"}) {
    const fs::path folder = mFolder / name.substr(0, 8);
    fs::create_directory(folder);
    const auto count = [&] { return std::distance(fs::directory_iterator(folder), {}); };
    // Two at once, as they may be where two runs were started.
    const Owner first(folder / name), second(folder / name), other(folder / (longName + "2.vdb"));
    AtomicFile(folder / name);
    EXPECT_EQ(count(), 3) << "all owners live";
    first.kill();
    other.kill();
    AtomicFile(folder / name);
    EXPECT_EQ(count(), 2) << "that of the one who lives, and that of the other file";
    second.kill();
    AtomicFile(folder / name).commit();
    EXPECT_EQ(count(), 2) << "the file, and what the other has left";
    AtomicFile(folder / (longName + "2.vdb"));
    EXPECT_EQ(count(), 1);
  }
}

// Promise: "No temporary file stays behind"
TEST_F(AtomicFileTest, IsNeverSweptAwayWhileItIsWritten) {
  std::atomic<bool> stop{false};
  std::vector<std::jthread> sweepers;
  for (int k = 0; k < 3; ++k)
    sweepers.emplace_back([&] {
      while (!stop) sweepTemporaries(mFolder);
    });
  for (int k = 0; k < 300; ++k) {
    AtomicFile file(mFolder / "x.vdb");
    file.stream() << k;
    file.commit();
    ASSERT_EQ(contentOf(mFolder / "x.vdb"), std::to_string(k));
  }
  stop = true;
}

TEST_F(AtomicFileTest, AMarkTellsWhetherItsWriterLives) {
  const fs::path mark = mFolder / "running";
  EXPECT_EQ(stateOfMark(mark), MarkState::None);
  {
    const MarkFile file(mark, "here");
    EXPECT_EQ(contentOf(mark), "here");
    EXPECT_EQ(stateOfMark(mark), MarkState::Alive);
    removeDeadMark(mark);
    EXPECT_EQ(stateOfMark(mark), MarkState::Alive);
  }
  EXPECT_EQ(stateOfMark(mark), MarkState::None);
  put(mark, "that of a process that was killed");
  EXPECT_EQ(stateOfMark(mark), MarkState::Dead);
  removeDeadMark(mark);
  EXPECT_EQ(stateOfMark(mark), MarkState::None);
  const MarkFile file(mark, "here");
  removeTemporaries();
  EXPECT_EQ(stateOfMark(mark), MarkState::None);
}

// Promise of design.md: "the disk of another machine did not answer" is 75 as well
TEST(IoFailure, SomeErrorsPass) {
  EXPECT_THROW(throwIoError("reading x failed", ESTALE), UnreachableError);
  EXPECT_THROW(throwIoError("reading x failed", ETIMEDOUT), UnreachableError);
  for (const int error : {EIO, ENOSPC, EDQUOT, EROFS}) {
    try {
      throwIoError("writing x failed", error);
    } catch (const UnreachableError&) {
      ADD_FAILURE() << std::strerror(error) << " does not pass by itself";
    } catch (const IoError& failure) {
      EXPECT_EQ(std::string(failure.what()).find("writing x failed: "), 0u);
    }
  }
}

}  // namespace
}  // namespace vdbtools
