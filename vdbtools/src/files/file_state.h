// SPDX-License-Identifier: Apache-2.0
/// @file file_state.h
/// Whether a file has changed, without reading it.
#pragma once

#include <cstdint>
#include <filesystem>

namespace vdbtools {

/// What the file system says of a file. Whoever changes or replaces the file changes this, too, even if its size and
/// its modification time stay: its inode or its time of change is another one.
struct FileState {
  std::uint64_t device = 0, number = 0, bytes = 0;
  std::int64_t modified = 0, changed = 0;  ///< nanoseconds since 1970

  bool operator==(const FileState&) const = default;
};

/// All zero for a file that is not there.
FileState stateOf(const std::filesystem::path& file);

}  // namespace vdbtools
