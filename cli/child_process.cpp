// SPDX-License-Identifier: Apache-2.0
#include "child_process.h"

#include "interruption.h"

#include "vdbtools/base/errors.h"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cli {
namespace {

/// The words as posix_spawn() takes them; they must outlive the result.
std::vector<char*> asArguments(std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return arguments;
}

int exitCodeOf(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

[[noreturn]] void waitingFailed() {
  throw vdbtools::IoError(std::string("waiting for a process: ") + std::strerror(errno));
}

}  // namespace

int runProgram(const std::vector<std::string>& words) {
  std::vector<std::string> copy = words;
  const std::vector<char*> arguments = asArguments(copy);
  // The child starts with the usual signal handling, not with that of this process.
  sigset_t none, usual;
  sigemptyset(&none);
  sigemptyset(&usual);
  for (const int signal : {SIGPIPE, SIGXFSZ}) sigaddset(&usual, signal);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setsigdefault(&attributes, &usual);
  holdSignals();
  pid_t child = 0;
  const int error = ::posix_spawn(&child, copy.at(0).c_str(), nullptr, &attributes, arguments.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  if (error != 0) throw vdbtools::IoError("cannot start '" + words.at(0) + "': " + std::strerror(error));
  handSignalsTo(child);
  for (;;) {
    int status = 0;
    if (::waitpid(child, &status, 0) == child) return exitCodeOf(status);
    if (errno != EINTR) waitingFailed();
  }
}

int runThisProgram(const std::vector<std::string>& words, const std::function<bool()>& cancelled) {
  constexpr const char* kThis = "/proc/self/exe";
  std::vector<std::string> copy = {"juliavdb"};
  copy.insert(copy.end(), words.begin(), words.end());
  const std::vector<char*> arguments = asArguments(copy);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, kThis, &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error != 0)
    throw vdbtools::IoError(std::string("cannot start another process of this program: ") + std::strerror(error));
  constexpr int kStep = 20;  // milliseconds
  bool asked = false;
  for (;;) {
    int status = 0;
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended < 0 && errno != EINTR) waitingFailed();
    if (ended == child) return exitCodeOf(status);
    if (!asked && cancelled()) {
      ::kill(child, SIGTERM);
      asked = true;
    }
    ::poll(nullptr, 0, kStep);
  }
}

}  // namespace cli
