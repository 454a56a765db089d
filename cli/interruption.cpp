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
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <iterator>
#include <new>
#include <string>
#include <string_view>
#include <thread>

#include <sys/uio.h>
#include <unistd.h>

namespace cli {
namespace {

std::atomic<bool> theInterrupted{false};
std::atomic<bool> theLastWordTaken{false};
std::atomic<int> theExitCode{kInterrupted};
std::atomic<int> theCrash{0};  // the signal

// The program promises to be gone within a second; this much is left to work that stops by itself.
constexpr std::chrono::milliseconds kGrace(700);

/// Ends the process from beside the work, with nothing written.
[[noreturn]] void endNow(int code, const char* text) noexcept {
  vdbtools::removeTemporaries();
  if (takeLastWord()) {
    if (report().json()) {
      try {
        report().end(code, text);
      } catch (const std::bad_alloc&) {
        // The exit code says it.
      }
    } else {
      // In one call, and without memory. On a terminal a progress bar may stand in the line.
      const std::string_view parts[] = {isatty(STDERR_FILENO) != 0 ? "\njuliavdb: " : "juliavdb: ", text, "\n"};
      iovec line[std::size(parts)];
      std::transform(std::begin(parts), std::end(parts), line, [](std::string_view part) {
        return iovec{.iov_base = const_cast<char*>(part.data()), .iov_len = part.size()};
      });
      [[maybe_unused]] const auto written = writev(STDERR_FILENO, line, std::size(line));
    }
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
    endNow(failure.code, failure.text.c_str());
  } catch (...) {
  }
  endNow(kInternal, "internal error: an exception found no handler");
}

/// A signal handler, which may call next to nothing: the watcher does the rest. Where it does not, because it has
/// crashed itself or waits for a lock of the thread that has, the signal ends the process.
void waitForEnd(int signal) {
  constexpr timespec kLongest = {.tv_sec = 2, .tv_nsec = 0};
  theCrash = signal;
  nanosleep(&kLongest, nullptr);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void watchForCrashes() {
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT}) {
    struct sigaction before {};
    // Sanitizers have handlers of their own.
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_DFL) std::signal(signal, waitForEnd);
  }
}

void endIfCrashed() noexcept {
  const int signal = theCrash;
  if (signal == 0) return;
  theLastWordTaken = false;
  char text[200];
  std::snprintf(text, sizeof text,
                "internal error: the program crashed (%s); what it had not finished is removed. Please report it, "
                "with the command line",
                sigdescr_np(signal));
  endNow(kInternal, text);
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
    const std::string text = "memory is running out: this run has taken " + vdbtools::memoryText(own) + ", and " +
                             left.limit + " leaves " + vdbtools::memoryText(left.bytes) +
                             "; nothing was written. Use a lower resolution, a --box, or 'juliavdb plan'";
    endNow(kInternal, text.c_str());
  } catch (const std::bad_alloc&) {
    // The work will see it, too.
  }
}

}  // namespace

void watchForInterruption() {
  std::set_terminate(endUnhandled);
  std::signal(SIGPIPE, SIG_IGN);  // a reader that is gone shows as a failed write
  std::signal(SIGXFSZ, SIG_IGN);  // and so does a file that 'ulimit -f' forbids
  watchForCrashes();
  static sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([] {
    constexpr timespec kPeriod = {.tv_sec = 0, .tv_nsec = 200'000'000};
    while (sigtimedwait(&signals, nullptr, &kPeriod) < 0) {
      endIfCrashed();
      endIfMemoryRunsOut();
    }
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
