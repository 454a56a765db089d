// SPDX-License-Identifier: Apache-2.0
/// @file interruption.h
/// Ctrl-C and SIGTERM: first as a wish that work looks at, then, for work that cannot, as the end of the process with
/// its temporary files removed. A crash, of a library as of the program, ends it in the same way.
#pragma once

namespace cli {

/// Call first in main(), before any thread exists: signals are handled by a thread of their own from then on. Those of
/// a crash make it end the process with exit code 70 and one line.
void watchForInterruption();

/// True once a signal came.
bool interrupted() noexcept;

/// For a command that runs until it is interrupted: from now on a signal ends the program without a word, with exit
/// code 0, even where work of it has to be cut off.
void expectInterruption() noexcept;

/// True for the first caller: of the two ways to stop, the one that says so. The other has nothing left to say.
bool takeLastWord() noexcept;

}  // namespace cli
