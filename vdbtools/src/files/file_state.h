// SPDX-License-Identifier: Apache-2.0
/// @file file_state.h
/// Detects whether a file has changed, without reading it.
#pragma once

#include <cstdint>
#include <filesystem>

namespace vdbtools {

/// The file system's record of a file. Changing or replacing the file changes this, too, even if its size and its
/// modification time stay the same, because its inode or its change time differs.
struct FileState {
  std::uint64_t device = 0, number = 0, bytes = 0;
  std::int64_t modified = 0, changed = 0;  ///< nanoseconds since 1970

  bool operator==(const FileState&) const = default;
};

/// All members are zero if the file does not exist.
FileState stateOf(const std::filesystem::path& file);

}  // namespace vdbtools
