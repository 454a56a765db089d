// SPDX-License-Identifier: Apache-2.0
/// @file gravest_code.h
/// The exit code of a command whose tasks have failed with several.
#pragma once

#include "exit_code.h"

#include <set>

namespace cli {

/// First what will fail again in the same way, and last what may not.
inline int gravestCode(const std::set<int>& codes) {
  for (const int code : {kInternal, kUsage, kBadData, kNoInput, kCannotCreate, kInputOutput})
    if (codes.contains(code)) return code;
  return kInterrupted;
}

}  // namespace cli
