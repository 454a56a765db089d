// SPDX-License-Identifier: Apache-2.0
/// @file image_threads.h
/// The number of threads that OpenImageIO and OpenEXR use, for the sources of the module of files/image_module.h.
#pragma once

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <latch>
#include <thread>
#include <vector>

namespace vdbtools {

/// How many of @a wanted threads the system lets this process start. OpenImageIO 2.4 crashes later if it could not
/// start one.
inline int startableThreads(int wanted) {
  std::latch end(1);
  std::vector<std::jthread> threads;
  threads.reserve(static_cast<std::size_t>(wanted));
  try {
    while (static_cast<int>(threads.size()) < wanted) threads.emplace_back([&end] { end.wait(); });
  } catch (const std::exception&) {
    // Only some could be started; they wait and must be released.
  }
  end.count_down();
  return static_cast<int>(threads.size());
}

/// Without this call, both start a thread for each processor. The number does not affect the bytes.
/// @param threads  maximum number; 1: only the caller's
inline void useImageThreads(int threads) {
  threads = std::max(1, startableThreads(2 * threads) / 2);
  OIIO::attribute("threads", threads);
  constexpr int kNone = -1;  // 0 stands for all processors
  OIIO::attribute("exr_threads", threads > 1 ? threads : kNone);
}

}  // namespace vdbtools
