// SPDX-License-Identifier: Apache-2.0
#include "interruption.h"

#include "exit_code.h"
#include "failure.h"
#include "report.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/input_files.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <initializer_list>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include <sys/uio.h>
#include <unistd.h>

#ifdef __EMSCRIPTEN__
#include <emscripten.h>
#endif

namespace cli {
namespace {

enum class Speaker { Nobody, Work, Watcher };

std::atomic<bool> theInterrupted{false};
std::atomic<bool> theInterruptionExpected{false};
std::atomic<bool> theWorkDone{false};
std::atomic<bool> thePlacing{false};
std::atomic<Speaker> theSpeaker{Speaker::Nobody};
std::atomic<int> theExitCode{kInterrupted};  // exit code of the work, once it speaks
std::atomic<int> theCrash{0};                // signal of a crash
std::atomic<bool> theSignalsHeld{false};
std::atomic<int> theGroup{0};  // process group to which signals are forwarded

// The program promises to end within a second; this is the part for work that stops by itself.
constexpr std::chrono::milliseconds kGrace(700);
// Printing a few words takes no time, unless nobody reads the pipe.
constexpr std::chrono::milliseconds kLastWords(200);
// Renaming takes no time, but flushing a folder may. A disk that is gone blocks forever.
constexpr std::chrono::seconds kLongestPlacing(10);

/// The work may claim it again, e.g. to report a failure after it has begun to report success.
bool claimLastWord(Speaker speaker) noexcept {
  Speaker before = Speaker::Nobody;
  return theSpeaker.compare_exchange_strong(before, speaker) || before == speaker;
}

/// Writes a line in a single call and without allocating. On a terminal it may have to overwrite a progress bar.
void writeLine(std::initializer_list<std::string_view> words) noexcept {
  constexpr std::size_t kMost = 8;
  iovec line[kMost];
  std::size_t count = 0;
  const auto add = [&](std::string_view word) {
    if (count < kMost) line[count++] = {.iov_base = const_cast<char*>(word.data()), .iov_len = word.size()};
  };
  add(isatty(STDERR_FILENO) != 0 ? "\njuliavdb: " : "juliavdb: ");
  for (const std::string_view word : words) add(word);
  add("\n");
  [[maybe_unused]] const auto written = writev(STDERR_FILENO, line, static_cast<int>(count));
}

/// Ends the process while the work is running. Unfinished output is removed.
[[noreturn]] void endNow(int code, std::string_view text) noexcept {
  vdbtools::removeTemporaries();
  if (!claimLastWord(Speaker::Watcher)) {
    std::this_thread::sleep_for(kLastWords);
    _exit(theExitCode);
  }
  if (report().json()) {
    try {
      report().end(code, std::string(text));
    } catch (const std::bad_alloc&) {
      // The exit code says so.
    }
  } else if (!text.empty()) {
    writeLine({text});
  }
  _exit(code);
}

void stopGroup() noexcept {
  if (const int group = theGroup; group > 0) ::kill(-group, SIGTERM);
}

/// As endNow(), for work that is stopped in an orderly way: says what is left of it, or what it has made if it had
/// finished.
/// @param why     the reason
/// @param remedy  empty, or a sentence
[[noreturn]] void stopNow(int code, const std::string& why, const std::string& remedy) noexcept {
  // No file is committed after this; those that have just been committed are not reported yet.
  vdbtools::removeTemporaries();
  const auto begin = std::chrono::steady_clock::now();
  const auto placing = [] { return thePlacing || vdbtools::placedFiles().now; };
  if (placing()) {
    while (placing() && std::chrono::steady_clock::now() - begin < kLongestPlacing)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::this_thread::sleep_for(kLastWords);  // gives the work time to say so
  }
  if (theInterruptionExpected) _exit(kDone);
  try {
    if (placing())
      endNow(code, why +
                       "; the files were being brought to their places, and the disk does not answer: look which of "
                       "them are there");
    // The work has had its time to report this itself.
    if (theWorkDone) endNow(kDone, report().json() ? std::string() : whatIsLeft());
    endNow(code, why + "; " + whatIsLeft() + (remedy.empty() ? "" : ". " + remedy));
  } catch (const std::bad_alloc&) {
    endNow(theWorkDone ? kDone : code, "stopped, and there is no memory left to say more");
  }
}

/// Handles uncaught exceptions: libraries throw out of destructors, while they are loaded, and across threads whose
/// exceptions need memory themselves when there is none.
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

/// A signal handler, which may call almost nothing: the watcher does the rest. If the watcher cannot, because it has
/// crashed itself or waits for a lock of the crashed thread, the signal ends the process.
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
    // Sanitizers install their own handlers.
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_DFL) std::signal(signal, waitForEnd);
  }
}

const char* describe(int signal) noexcept {
#ifdef __GLIBC__
  return sigdescr_np(signal);
#else
  return strsignal(signal);
#endif
}

void endIfCrashed() noexcept {
  const int signal = theCrash;
  if (signal == 0) return;
  theSpeaker = Speaker::Nobody;
  char text[200];
  std::snprintf(text, sizeof text,
                "internal error: the program crashed (%s); what it had not finished is removed. Please report it, "
                "with the command line",
                describe(signal));
  endNow(kInternal, text);
}

void endIfMemoryRunsOut() noexcept {
  try {
    if (const std::optional<std::string> why = vdbtools::memoryRunsOut())
      stopNow(kInternal, *why, "Use a lower resolution, a --box, or 'juliavdb plan'");
  } catch (const std::bad_alloc&) {
    // The work will see it, too.
  }
}

#ifdef __EMSCRIPTEN__
void blockSignals() noexcept {}

/// Waits a moment. @return whether the program is to end. Node hears signals, and calls juliavdb_interrupt().
bool waitForSignal() noexcept {
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  return theInterrupted;
}
#else
sigset_t theSignals;

void blockSignals() noexcept {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that is gone causes a failed write
  std::signal(SIGXFSZ, SIG_IGN);  // and so does a file that 'ulimit -f' forbids
  sigemptyset(&theSignals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&theSignals, signal);
  pthread_sigmask(SIG_BLOCK, &theSignals, nullptr);
}

/// Waits a moment for a signal. @return whether the program is to end
bool waitForSignal() noexcept {
  constexpr timespec kPeriod = {.tv_sec = 0, .tv_nsec = 200'000'000};
  return sigtimedwait(&theSignals, nullptr, &kPeriod) >= 0;
}
#endif

}  // namespace

#ifdef __EMSCRIPTEN__
/// wasm/node_process.js calls it.
extern "C" EMSCRIPTEN_KEEPALIVE void juliavdb_interrupt() { theInterrupted = true; }
#endif

void watchForInterruption() {
  std::set_terminate(endUnhandled);
  blockSignals();
  watchForCrashes();
  std::thread([] {
    for (;;) {
      if (!waitForSignal()) {
        endIfCrashed();
        endIfMemoryRunsOut();
        continue;
      }
      theInterrupted = true;
      if (!theSignalsHeld) break;
      stopGroup();
    }
    std::this_thread::sleep_for(kGrace);
    stopNow(kInterrupted, "interrupted", "");
  }).detach();
}

bool interrupted() noexcept { return theInterrupted && !theWorkDone; }

Placing::Placing() noexcept { thePlacing = true; }
Placing::~Placing() { thePlacing = false; }

void workIsDone() noexcept { theWorkDone = true; }

std::string whatIsLeft() {
  std::string known = report().whatIsLeft();
  if (!known.empty()) return known;
  return vdbtools::placedFiles().count > 0 ? "what was finished before is whole" : "nothing was written";
}

void holdSignals() noexcept { theSignalsHeld = true; }

void handSignalsTo(int group) noexcept {
  theGroup = group;
  if (theInterrupted) stopGroup();
}

void expectInterruption() noexcept { theInterruptionExpected = true; }

void takeLastWord(int code) noexcept {
  theExitCode = code;
  while (!claimLastWord(Speaker::Work)) std::this_thread::sleep_for(std::chrono::seconds(1));
}

}  // namespace cli
