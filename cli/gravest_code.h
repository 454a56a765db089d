// SPDX-License-Identifier: Apache-2.0
/// @file gravest_code.h
/// Chooses the exit code of a command whose tasks have failed with several codes.
#pragma once

#include "exit_code.h"

#include <set>

namespace cli {

/// Failures that will occur again in the same way come first, and those that may not occur again come last.
inline int gravestCode(const std::set<int>& codes) {
  for (const int code : {kInternal, kUsage, kBadData, kNoInput, kCannotCreate, kInputOutput})
    if (codes.contains(code)) return code;
  return kInterrupted;
}

}  // namespace cli
