// SPDX-License-Identifier: Apache-2.0
/// @file started.cpp
/// A library to be preloaded, for tests of some thousands of runs: of a short run the start costs the most, in which
/// the libraries are bound. The program stops before its main(), and each request on its standard input makes a copy of
/// it there, which runs main() with the words of the request. So each run is a process of its own, as fresh as any
/// other.
///
/// A request is a number in a line, that of its strings, and these, each of them ended by a zero: the folder in which
/// it runs, the files for its standard output and error, the seconds after which it is stopped, and the words. The
/// answer is a line of the status of waitpid().
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

using Main = int (*)(int, char**, char**);

Main gMain = nullptr;
constexpr std::size_t kFolder = 0, kOutput = 1, kError = 2, kSeconds = 3, kWords = 4;

/// Ends the server where it would give a wrong answer.
[[noreturn]] void giveUp(const char* what) {
  std::perror(what);
  _exit(127);
}

void open(int number, const char* name, int flags) {
  constexpr mode_t kMode = 0644;
  const int file = ::open(name, flags, kMode);
  if (file < 0 || dup2(file, number) < 0) giveUp(name);
  if (file != number) close(file);
}

/// The words of the next request; none at the end.
std::vector<std::string> request() {
  std::size_t count = 0;
  std::vector<std::string> strings;
  if (std::scanf("%zu", &count) != 1) return strings;
  std::getchar();
  for (int c = 0; strings.size() < count; strings.back().pop_back()) {
    strings.emplace_back();
    do {
      c = std::getchar();
      if (c == EOF) giveUp("a request is cut short");
      strings.back().push_back(static_cast<char>(c));
    } while (c != 0);
  }
  return strings;
}

int serve(int, char** argv, char** environment) {
  for (std::vector<std::string> strings; !(strings = request()).empty();) {
    const pid_t child = fork();
    if (child < 0) giveUp("fork");
    if (child == 0) {
      if (chdir(strings[kFolder].c_str()) != 0) giveUp("chdir");
      open(STDIN_FILENO, "/dev/null", O_RDONLY);
      open(STDOUT_FILENO, strings[kOutput].c_str(), O_WRONLY | O_CREAT | O_TRUNC);
      open(STDERR_FILENO, strings[kError].c_str(), O_WRONLY | O_CREAT | O_TRUNC);
      alarm(static_cast<unsigned>(std::atoi(strings[kSeconds].c_str())));
      std::vector<char*> words{argv[0]};
      for (std::size_t i = kWords; i < strings.size(); ++i) words.push_back(strings[i].data());
      words.push_back(nullptr);
      const int code = gMain(static_cast<int>(words.size()) - 1, words.data(), environment);
      std::fflush(nullptr);
      // Without the ends of the libraries: log4cplus waits there for threads of its own, which a copy does not have.
      _exit(code);
    }
    int status = 0;
    if (waitpid(child, &status, 0) != child) giveUp("waitpid");
    std::printf("%d\n", status);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

extern "C" int __libc_start_main(Main program, int argc, char** argv, void (*init)(), void (*fini)(),
                                 void (*finiOfLoader)(), void* endOfStack) {
  gMain = program;
  const auto next = reinterpret_cast<decltype(&__libc_start_main)>(dlsym(RTLD_NEXT, "__libc_start_main"));
  return next(serve, argc, argv, init, fini, finiOfLoader, endOfStack);
}
