// SPDX-License-Identifier: Apache-2.0
/// @file scheduler.h
/// Starts the scheduler of oneTBB while there is still enough memory for it.
#pragma once

namespace vdbtools {

/// Starts oneTBB's scheduler for the calling thread, without any worker thread. A program that may run out of memory
/// calls it before its first parallel loop, because oneTBB waits forever if it finds no memory while it starts or while
/// it makes room for its first tasks.
/// @throw std::bad_alloc  there is too little memory, and nothing was started
void startScheduler();

}  // namespace vdbtools
