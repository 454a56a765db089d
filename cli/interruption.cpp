// SPDX-License-Identifier: Apache-2.0
#include "interruption.h"

#include "exit_code.h"
#include "report.h"

#include "vdbtools/files/atomic_file.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <string_view>
#include <thread>

#include <unistd.h>

namespace cli {
namespace {

std::atomic<bool> theInterrupted{false};
std::atomic<bool> theLastWordTaken{false};
std::atomic<int> theExitCode{kInterrupted};

// The program promises to be gone within a second; this much is left to work that stops by itself.
constexpr std::chrono::milliseconds kGrace(700);

}  // namespace

void watchForInterruption() {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that is gone shows as a failed write
  std::signal(SIGXFSZ, SIG_IGN);  // and so does a file that 'ulimit -f' forbids
  static sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([] {
    int signal = 0;
    sigwait(&signals, &signal);
    theInterrupted = true;
    std::this_thread::sleep_for(kGrace);
    vdbtools::removeTemporaries();
    // On a terminal a progress bar may stand in the line.
    constexpr std::string_view kText = "\njuliavdb: interrupted; nothing was written\n";
    const std::string_view text = kText.substr(isatty(STDERR_FILENO) != 0 ? 0 : 1);
    if (takeLastWord()) {
      if (report().json())
        report().end(kInterrupted, "interrupted; nothing was written");
      else [[maybe_unused]]
        const auto written = write(STDERR_FILENO, text.data(), text.size());
    }
    _exit(theExitCode);
  }).detach();
}

bool interrupted() noexcept { return theInterrupted; }

void expectInterruption() noexcept {
  theLastWordTaken = true;
  theExitCode = kDone;
}

bool takeLastWord() noexcept { return !theLastWordTaken.exchange(true); }

}  // namespace cli
