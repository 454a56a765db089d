// SPDX-License-Identifier: Apache-2.0
/// @file interruption.h
/// Handles Ctrl-C and SIGTERM: first as a request that the work polls, then, for work that cannot poll it, by ending
/// the process after removing its temporary files. A crash of the program or a library ends the process likewise.
#pragma once

#include <string>

namespace cli {

/// Call first in main(), before any thread exists: from then on a separate thread handles signals. A crash ends the
/// process with exit code 70 and one line.
void watchForInterruption();

/// Whether a signal to stop the work has arrived.
bool interrupted() noexcept;

/// Exists while files are being committed and recorded in report(); a signal waits until then.
class Placing {
 public:
  Placing() noexcept;
  ~Placing();
  Placing(const Placing&) = delete;
  Placing& operator=(const Placing&) = delete;
};

/// Declares that all outputs of the command are committed, so there is nothing left to interrupt. From now on a signal
/// ends the program with exit code 0, at the latest after the usual grace period.
void workIsDone() noexcept;

/// What an interruption at this moment leaves behind, such as "nothing was written".
std::string whatIsLeft();

/// For a command that runs until it is interrupted: from now on a signal ends the program silently with exit code 0,
/// even if its work is cut off.
void expectInterruption() noexcept;

/// For a command that waits for other processes, which are asked to stop instead: from now on a signal does not end
/// this process. It is forwarded as SIGTERM to the process group of handSignalsTo(), even if it arrived earlier.
void holdSignals() noexcept;
void handSignalsTo(int group) noexcept;

/// Call before the final message. The program can end in two ways, by the work and by the signal thread, and only the
/// first prints anything. If the work comes second, this does not return before the process ends.
/// @param code  the exit code with which the program is about to end
void takeLastWord(int code) noexcept;

}  // namespace cli
