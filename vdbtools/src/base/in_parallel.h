// SPDX-License-Identifier: Apache-2.0
/// @file in_parallel.h
/// Loops in threads that stop when they are asked to.
#pragma once

#include "vdbtools/base/monitor.h"

#include <tbb/parallel_for.h>

#include <cstddef>

namespace vdbtools {

/// Runs body(begin, end) over parts of 0 to @a count in threads, parts of at least @a grain if there are so many.
/// @throw Interrupted  the work was cancelled meanwhile; parts were left out
template <class Body>
void inParallel(std::size_t count, std::size_t grain, const Monitor& monitor, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    if (!monitor.cancelled()) body(range.begin(), range.end());
  });
  monitor.throwIfCancelled();
}

}  // namespace vdbtools
