// SPDX-License-Identifier: Apache-2.0
/// @file temporary_folder.h
/// A place for the files of one test. Tests run at the same time, and the whole suite may run twice at once, so that
/// no test writes under a name that another could use: each takes a folder of its own here.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

/// A new folder, removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "juliavdb_test_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder " + pattern);
    mPath = std::filesystem::canonical(pattern);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(mPath, ignored);
  }

  /// Absolute, without symbolic links.
  const std::filesystem::path& path() const { return mPath; }

  /// A file in this folder.
  std::filesystem::path write(const std::string& name, std::string_view contents) const {
    std::ofstream stream(mPath / name, std::ios::binary);
    stream.write(contents.data(), static_cast<std::streamsize>(contents.size()));
    return mPath / name;
  }

 private:
  std::filesystem::path mPath;
};
