// SPDX-License-Identifier: Apache-2.0
#include "child_process.h"

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

int runThisProgram(const std::vector<std::string>& words, const std::function<bool()>& cancelled) {
  constexpr const char* kThis = "/proc/self/exe";
  std::vector<std::string> copy = {"juliavdb"};
  copy.insert(copy.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : copy) arguments.push_back(word.data());
  arguments.push_back(nullptr);
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
    if (ended < 0 && errno != EINTR)
      throw vdbtools::IoError(std::string("waiting for a process: ") + std::strerror(errno));
    if (ended == child) return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (!asked && cancelled()) {
      ::kill(child, SIGTERM);
      asked = true;
    }
    ::poll(nullptr, 0, kStep);
  }
}

}  // namespace cli
