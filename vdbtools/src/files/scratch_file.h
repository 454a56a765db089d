// SPDX-License-Identifier: Apache-2.0
/// @file scratch_file.h
/// Bytes stored on the disk in an unnamed file, which disappears with this object, and with the process however it
/// ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>

namespace vdbtools {

/// Opens an unnamed file for reading and writing, which disappears when it is closed.
/// @return its descriptor, or -1 with errno
int openNameless(const std::filesystem::path& folder);

/// The folder for temporary files that belong to no output: TMPDIR, or else /tmp.
/// @throw CreateError  there is no such folder
std::filesystem::path scratchFolder();

class ScratchFile {
 public:
  /// @param folder  empty: the working directory
  /// @throw CreateError  no file can be created there
  explicit ScratchFile(const std::filesystem::path& folder);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  /// Writes without a buffer. @throw IoError  e.g. a full disk or a lost mount
  void append(std::string_view bytes);

  /// Writes all bytes to @a stream until it fails, and frees their space on the disk progressively.
  /// @throw IoError  reading failed midway
  void moveTo(std::ostream& stream);

  /// A path by which this process can open the bytes for reading, as long as this object lives.
  std::filesystem::path pathWhileOpen() const;

 private:
  [[noreturn]] void fail(const std::string& reason) const;

  std::string mFolder;  ///< for messages
  int mDescriptor = -1;
  std::int64_t mSize = 0;  ///< bytes
};

}  // namespace vdbtools
