// SPDX-License-Identifier: Apache-2.0
/// @file image_threads.h
/// How many threads OpenImageIO and OpenEXR use, for the sources of the module of files/image_module.h.
#pragma once

#include <OpenImageIO/imageio.h>

namespace vdbtools {

/// Without it, both start a thread for each processor. The bytes are the same with any number.
/// @param threads  1: none but the caller's
inline void useImageThreads(int threads) {
  OIIO::attribute("threads", threads);
  constexpr int kNone = -1;  // 0 stands for all processors
  OIIO::attribute("exr_threads", threads > 1 ? threads : kNone);
}

}  // namespace vdbtools
