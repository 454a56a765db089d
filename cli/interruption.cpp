// SPDX-License-Identifier: Apache-2.0
#include "interruption.h"

#include "exit_code.h"
#include "failure.h"
#include "report.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/files/atomic_file.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <exception>
#include <new>
#include <string>
#include <thread>

#include <unistd.h>

namespace cli {
namespace {

std::atomic<bool> theInterrupted{false};
std::atomic<bool> theLastWordTaken{false};
std::atomic<int> theExitCode{kInterrupted};

// The program promises to be gone within a second; this much is left to work that stops by itself.
constexpr std::chrono::milliseconds kGrace(700);

/// Ends the process from beside the work, with nothing written.
[[noreturn]] void endNow(int code, const std::string& text) noexcept {
  vdbtools::removeTemporaries();
  if (takeLastWord()) {
    try {
      if (report().json()) report().end(code, text);
    } catch (const std::bad_alloc&) {
      // The exit code says it.
    }
    // On a terminal a progress bar may stand in the line.
    const std::string line = (isatty(STDERR_FILENO) != 0 ? "\njuliavdb: " : "juliavdb: ") + text + "\n";
    if (!report().json()) [[maybe_unused]]
      const auto written = write(STDERR_FILENO, line.data(), line.size());
  }
  _exit(code);
}

/// For exceptions that find no handler: libraries throw out of destructors, while they are loaded, and across threads
/// whose exceptions take memory themselves, once there is none.
[[noreturn]] void endUnhandled() noexcept {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    endNow(kInternal, "out of memory");
  } catch (const std::exception&) {
    const Failure failure = currentFailure();
    endNow(failure.code, failure.text);
  } catch (...) {
  }
  endNow(kInternal, "internal error: an exception found no handler");
}

/// Whoever takes the last of a machine's memory makes it stand still, and is killed before long.
void endIfMemoryRunsOut() noexcept {
  constexpr double kLeastReserve = 32 << 20, kReserveShare = 0.01;  // bytes; of what the process has
  try {
    const double own = vdbtools::residentMemory();
    // What has not taken much is not to blame, and frees little.
    if (own < 16 * kLeastReserve) return;
    const vdbtools::MemoryLeft left = vdbtools::sharedMemoryLeft();
    if (left.bytes > std::max(kLeastReserve, kReserveShare * own)) return;
    endNow(kInternal, "memory is running out: this run has taken " + vdbtools::memoryText(own) + ", and " + left.limit +
                          " leaves " + vdbtools::memoryText(left.bytes) +
                          "; nothing was written. Use a lower resolution, a --box, or 'juliavdb plan'");
  } catch (const std::bad_alloc&) {
    // The work will see it, too.
  }
}

}  // namespace

void watchForInterruption() {
  std::set_terminate(endUnhandled);
  std::signal(SIGPIPE, SIG_IGN);  // a reader that is gone shows as a failed write
  std::signal(SIGXFSZ, SIG_IGN);  // and so does a file that 'ulimit -f' forbids
  static sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([] {
    constexpr timespec kPeriod = {.tv_sec = 0, .tv_nsec = 200'000'000};
    while (sigtimedwait(&signals, nullptr, &kPeriod) < 0) endIfMemoryRunsOut();
    theInterrupted = true;
    std::this_thread::sleep_for(kGrace);
    endNow(theExitCode, "interrupted; nothing was written");
  }).detach();
}

bool interrupted() noexcept { return theInterrupted; }

void expectInterruption() noexcept {
  theLastWordTaken = true;
  theExitCode = kDone;
}

bool takeLastWord() noexcept { return !theLastWordTaken.exchange(true); }

}  // namespace cli
