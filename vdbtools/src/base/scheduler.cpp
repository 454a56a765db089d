// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/scheduler.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <thread>

namespace vdbtools {
namespace {

/// The memory that the scheduler and its allocator map when they start, measured with oneTBB 2021.8 and 2022.1: 6.6
/// MiB, a part of which grows with the number of processors.
constexpr std::size_t kStart = std::size_t{8} << 20, kProcessor = std::size_t{16} << 10;

/// @throw std::bad_alloc  so many bytes cannot be mapped
void requireMapping(std::size_t bytes) {
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  munmap(memory, bytes);
}

}  // namespace

void startScheduler() {
  // oneTBB has two faults that its users have to avoid. While version 2022.1 creates its scheduler, it holds the locks
  // of all global controls. If an allocation fails there, it asks one of these controls whether to throw, and so waits
  // for itself. The second fault: if the room for a thread's first tasks cannot be allocated, the loop waits for a task
  // that was counted, but never queued.
  requireMapping(kStart + kProcessor * std::thread::hardware_concurrency());
  // An arena of one thread starts no other. The memory of its tasks stays with oneTBB's allocator, for later loops.
  tbb::task_arena(1).execute([] { tbb::parallel_for(0, 64, [](int) {}); });
}

}  // namespace vdbtools
