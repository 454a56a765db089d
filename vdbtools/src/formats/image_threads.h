// SPDX-License-Identifier: Apache-2.0
/// @file image_threads.h
/// How many threads OpenImageIO and OpenEXR use, for the sources of the module of files/image_module.h.
#pragma once

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <latch>
#include <thread>
#include <vector>

namespace vdbtools {

/// How many of so many threads the system lets this process start. OpenImageIO 2.4 crashes later where it could not
/// start one.
inline int startableThreads(int wanted) {
  std::latch end(1);
  std::vector<std::jthread> threads;
  threads.reserve(static_cast<std::size_t>(wanted));
  try {
    while (static_cast<int>(threads.size()) < wanted) threads.emplace_back([&end] { end.wait(); });
  } catch (const std::exception&) {
    // As many as there are; they wait, and must not be left so.
  }
  end.count_down();
  return static_cast<int>(threads.size());
}

/// Without it, both start a thread for each processor. The bytes are the same with any number.
/// @param threads  at most; 1: none but the caller's
inline void useImageThreads(int threads) {
  threads = std::max(1, startableThreads(2 * threads) / 2);
  OIIO::attribute("threads", threads);
  constexpr int kNone = -1;  // 0 stands for all processors
  OIIO::attribute("exr_threads", threads > 1 ? threads : kNone);
}

}  // namespace vdbtools
