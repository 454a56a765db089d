// SPDX-License-Identifier: Apache-2.0
/// @file child_process.h
/// Runs this program again, or another one, as a child process.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace cli {

/// Runs this program, discards its stderr, and waits for it. Once @a cancelled returns true, the child is asked to
/// stop.
/// @param words  the words of its command line, after the name of the program
/// @return its exit code; 128 and the signal's number if a signal ended it
/// @throw vdbtools::IoError  it cannot be started
int runThisProgram(const std::vector<std::string>& words, const std::function<bool()>& cancelled);

/// Runs another program, in a process group of its own, and waits for it. A request to stop this process is from now on
/// forwarded to that group (holdSignals()), and the end of the group determines the result.
/// @param words  its path, and the words of its command line
/// @return its exit code; 128 and the signal's number if a signal ended it
/// @throw vdbtools::IoError  it cannot be started
int runProgram(const std::vector<std::string>& words);

}  // namespace cli
