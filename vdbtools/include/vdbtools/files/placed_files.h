// SPDX-License-Identifier: Apache-2.0
/// @file placed_files.h
/// Which files an interruption leaves behind, for a thread that ends the process during the work.
#pragma once

#include <cstddef>

namespace vdbtools {

struct PlacedFiles {
  bool now = false;       ///< some files are being renamed, or their folders flushed, at this moment
  std::size_t count = 0;  ///< number of files that this process has renamed over their targets so far
};

/// Counts all committed files (atomic_file.h). After removeTemporaries() the count does not grow any more.
PlacedFiles placedFiles() noexcept;

}  // namespace vdbtools
