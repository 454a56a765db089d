// SPDX-License-Identifier: Apache-2.0
/// @file scheduler.h
/// The scheduler of oneTBB, started while its memory is certain.
#pragma once

namespace vdbtools {

/// Starts oneTBB's scheduler for the calling thread, without any worker thread. A program that may run out of memory
/// calls it before its first parallel loop: where memory fails while oneTBB starts, or while it makes room for its
/// first tasks, oneTBB waits forever.
/// @throw std::bad_alloc  there is too little memory, and nothing was started
void startScheduler();

}  // namespace vdbtools
