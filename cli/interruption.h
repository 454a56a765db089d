// SPDX-License-Identifier: Apache-2.0
/// @file interruption.h
/// Ctrl-C and SIGTERM: first as a wish that work looks at, then, for work that cannot, as the end of the process with
/// its temporary files removed. A crash, of a library as of the program, ends it in the same way.
#pragma once

#include <string>

namespace cli {

/// Call first in main(), before any thread exists: signals are handled by a thread of their own from then on. Those of
/// a crash make it end the process with exit code 70 and one line.
void watchForInterruption();

/// True once a signal came that is to stop the work.
bool interrupted() noexcept;

/// While one exists, files are being brought to their places, and a signal waits until report() knows of them.
class Placing {
 public:
  Placing() noexcept;
  ~Placing();
  Placing(const Placing&) = delete;
  Placing& operator=(const Placing&) = delete;
};

/// All that the command was to make is in its place: there is nothing left to interrupt. From now on a signal ends the
/// program with exit code 0, and at the latest after the grace that work has.
void workIsDone() noexcept;

/// What an interruption at this moment leaves, such as "nothing was written".
std::string whatIsLeft();

/// For a command that runs until it is interrupted: from now on a signal ends the program without a word, with exit
/// code 0, even where work of it has to be cut off.
void expectInterruption() noexcept;

/// For a command that waits for other processes, which are asked to stop in its place: from now on a signal ends
/// nothing here. It is handed on as SIGTERM to the process group of handSignalsTo(), also if it came before that.
void holdSignals() noexcept;
void handSignalsTo(int group) noexcept;

/// Call before the last thing is said. Of the two ways to end, by the work and beside it, only the first to come says
/// anything; where the work comes second, this does not return before the process ends.
/// @param code  the exit code with which the program is about to end
void takeLastWord(int code) noexcept;

}  // namespace cli
