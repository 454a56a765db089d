// SPDX-License-Identifier: Apache-2.0
/// @file child_process.h
/// This program once more, as a process of its own.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace cli {

/// Runs this program, without what it says on stderr, and waits for it. Once @a cancelled is true, the child is asked
/// to stop.
/// @param words  of its command line, after the name of the program
/// @return its exit code; 128 and the signal's number if a signal ended it
/// @throw vdbtools::IoError  it cannot be started
int runThisProgram(const std::vector<std::string>& words, const std::function<bool()>& cancelled);

/// Runs another program, in a process group of its own, and waits for it. Whoever asks this process to stop asks that
/// group from then on (holdSignals()), and learns from how it ends.
/// @param words  its path, and those of its command line
/// @return its exit code; 128 and the signal's number if a signal ended it
/// @throw vdbtools::IoError  it cannot be started
int runProgram(const std::vector<std::string>& words);

}  // namespace cli
