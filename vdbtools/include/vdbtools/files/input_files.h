// SPDX-License-Identifier: Apache-2.0
/// @file input_files.h
/// The files that a job reads, which protects them from being overwritten by its outputs.
#pragma once

#include "vdbtools/files/named_file.h"

#include <sys/types.h>
#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace vdbtools {

// Which files an interruption leaves behind, for a thread that ends the process during the work.

struct PlacedFiles {
  bool now = false;       ///< some files are being renamed, or their folders flushed, at this moment
  std::size_t count = 0;  ///< number of files that this process has renamed over their targets so far
};

/// Counts all committed files (atomic_file.h). After removeTemporaries() the count does not grow any more.
PlacedFiles placedFiles() noexcept;

/// Two files are the same if the file system says so: through symbolic and hard links and in any spelling. Devices,
/// pipes and folders are never inputs in this sense, because writing to them does not replace them.
class InputFiles {
 public:
  InputFiles() = default;
  explicit InputFiles(std::span<const NamedFile> files) {
    for (const NamedFile& file : files) add(file.path);
  }

  void add(const std::filesystem::path& file);
  void add(const InputFiles& others);
  /// Adds every file in the folder and below it, including files that do not exist yet.
  void addFolder(const std::filesystem::path& folder);

  /// Each file by one of the names under which it was added.
  std::vector<std::filesystem::path> files() const;

  /// @throw std::invalid_argument  the output is one of them; the message names both
  void requireNot(const std::filesystem::path& output) const;

 private:
  // Each entry has the name as it was given. If another process replaces a file meanwhile, only its path is still
  // protected.
  std::map<std::filesystem::path, std::filesystem::path> mPlaces, mFolders;
  std::map<std::pair<dev_t, ino_t>, std::filesystem::path> mFiles;
};

}  // namespace vdbtools
