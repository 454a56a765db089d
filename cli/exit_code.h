// SPDX-License-Identifier: Apache-2.0
/// @file exit_code.h
/// The program's exit statuses, which follow sysexits.h where possible.
#pragma once

#include <set>

namespace cli {

enum ExitCode {
  kDone = 0,
  kUsage = 2,          ///< unknown option, value out of its domain
  kBadData = 65,       ///< leaky mesh, broken file, empty result
  kNoInput = 66,       ///< no such input
  kInternal = 70,      ///< memory is short, or a bug
  kCannotCreate = 73,  ///< the output's path cannot be written
  kInputOutput = 74,   ///< reading or writing failed midway
  kInterrupted = 75,   ///< stopped by a signal, or the disk of another machine did not answer; try again
};

/// The exit code of a command whose tasks have failed with several codes.
/// Failures that will occur again in the same way come first, and those that may not occur again come last.
inline int gravestCode(const std::set<int>& codes) {
  for (const int code : {kInternal, kUsage, kBadData, kNoInput, kCannotCreate, kInputOutput})
    if (codes.contains(code)) return code;
  return kInterrupted;
}

}  // namespace cli
