// SPDX-License-Identifier: Apache-2.0
/// @file threads.h
/// How many threads the program may use.
#pragma once

#include <tbb/global_control.h>

namespace vdbtools {

/// What `--threads` or whoever uses the library allows, for those that do not ask oneTBB.
inline int allowedThreads() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace vdbtools
