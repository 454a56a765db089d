// SPDX-License-Identifier: Apache-2.0
/// @file threads.h
/// The number of threads that the program may use.
#pragma once

#include <tbb/global_control.h>

namespace vdbtools {

/// The number allowed by `--threads` or the library's user, for code that does not use oneTBB.
inline int allowedThreads() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace vdbtools
