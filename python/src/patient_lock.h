// SPDX-License-Identifier: Apache-2.0
/// @file patient_lock.h
/// Locks for results that one thread makes while others wait for it.
#pragma once

#include "vdbtools/base/monitor.h"

#include <chrono>
#include <mutex>

/// Locks a mutex whose holder may work for a long time.
/// @throw vdbtools::Interrupted
inline std::unique_lock<std::timed_mutex> lockPatiently(std::timed_mutex& mutex, const vdbtools::Monitor& monitor) {
  constexpr std::chrono::milliseconds kStep(50);
  std::unique_lock lock(mutex, std::defer_lock);
  while (!lock.try_lock_for(kStep)) monitor.throwIfCancelled();
  return lock;
}
