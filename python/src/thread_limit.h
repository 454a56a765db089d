// SPDX-License-Identifier: Apache-2.0
/// @file thread_limit.h
/// The number of threads that a call takes.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

/// Runs @a work in an arena with this number of threads; 0: with all of them.
template <class Function>
void inThreads(int threads, const Function& work) {
  if (threads == 0) return work();
  // oneTBB would print a warning where an arena asks for more.
  const std::size_t allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  tbb::task_arena arena(static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads), allowed)));
  arena.execute(work);
}
