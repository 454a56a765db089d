// SPDX-License-Identifier: Apache-2.0
/// @file input_files.h
/// The files that a job reads, so that none of them becomes one of its outputs.
#pragma once

#include "vdbtools/files/named_file.h"

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace vdbtools {

/// Files are the same if they are so for the file system: through links of both kinds and in any spelling. Devices,
/// pipes and folders are never inputs in this sense, as nothing that is written to them replaces them.
class InputFiles {
 public:
  InputFiles() = default;
  explicit InputFiles(std::span<const NamedFile> files) {
    for (const NamedFile& file : files) add(file.path);
  }

  void add(const std::filesystem::path& file);
  void add(const InputFiles& others);
  /// Every file in the folder and below it, also those that are not there yet.
  void addFolder(const std::filesystem::path& folder);

  /// Each file by a name under which it was added.
  std::vector<std::filesystem::path> files() const;

  /// @throw std::invalid_argument  the output is one of them; it names both
  void requireNot(const std::filesystem::path& output) const;

 private:
  // Each with its name as it was given. A file that another process replaces meanwhile keeps its place alone.
  std::map<std::filesystem::path, std::filesystem::path> mPlaces, mFolders;
  std::map<std::pair<dev_t, ino_t>, std::filesystem::path> mFiles;
};

}  // namespace vdbtools
