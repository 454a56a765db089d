// SPDX-License-Identifier: Apache-2.0
/// @file in_parallel.h
/// Parallel loops that stop on cancellation.
#pragma once

#include "vdbtools/base/monitor.h"

#include <tbb/parallel_for.h>

#include <cstddef>

namespace vdbtools {

/// Runs body(begin, end) in threads over parts of 0 to @a count, each of at least @a grain if possible.
/// @throw Interrupted  the work was cancelled meanwhile; parts were left out
template <class Body>
void inParallel(std::size_t count, std::size_t grain, const Monitor& monitor, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    if (!monitor.cancelled()) body(range.begin(), range.end());
  });
  monitor.throwIfCancelled();
}

}  // namespace vdbtools
