// SPDX-License-Identifier: Apache-2.0
/// @file placed_files.h
/// Which files an interruption leaves, for whoever ends the process from beside the work.
#pragma once

#include <cstddef>

namespace vdbtools {

struct PlacedFiles {
  bool now = false;       ///< some are being renamed, or their folders flushed, at this moment
  std::size_t count = 0;  ///< that this process has renamed over their targets so far
};

/// Of all files that were committed (atomic_file.h). After removeTemporaries() the count grows no more.
PlacedFiles placedFiles() noexcept;

}  // namespace vdbtools
