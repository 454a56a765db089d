// SPDX-License-Identifier: Apache-2.0
/// @file timed_locks.cpp
/// std::timed_mutex waits by pthread_mutex_clocklock(), which ThreadSanitizer of clang 14 does not know. It knows
/// pthread_mutex_timedlock(), which does the same by the other clock.
#include <pthread.h>

#include <ctime>

extern "C" __attribute__((visibility("default"))) int pthread_mutex_clocklock(pthread_mutex_t* mutex, clockid_t clock,
                                                                              const timespec* until) noexcept {
  constexpr long kNanoseconds = 1'000'000'000;
  timespec now{}, end{};
  clock_gettime(clock, &now);
  clock_gettime(CLOCK_REALTIME, &end);
  end.tv_sec += until->tv_sec - now.tv_sec;
  end.tv_nsec += until->tv_nsec - now.tv_nsec;
  while (end.tv_nsec >= kNanoseconds) {
    end.tv_nsec -= kNanoseconds;
    ++end.tv_sec;
  }
  while (end.tv_nsec < 0) {
    end.tv_nsec += kNanoseconds;
    --end.tv_sec;
  }
  return pthread_mutex_timedlock(mutex, &end);
}
