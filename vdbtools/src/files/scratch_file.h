// SPDX-License-Identifier: Apache-2.0
/// @file scratch_file.h
/// Bytes put aside on the disk in a file without a name, which disappears with this object, and with the process
/// however that ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>

namespace vdbtools {

class ScratchFile {
 public:
  /// @param folder  empty: the working directory
  /// @throw CreateError  no file can be made there
  explicit ScratchFile(const std::filesystem::path& folder);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  /// Unbuffered. @throw IoError  a full disk, a lost mount
  void append(std::string_view bytes);

  /// Writes all bytes to @a stream, as far as that accepts them, and frees their space on the disk on the way.
  /// @throw IoError  reading broke off
  void moveTo(std::ostream& stream);

 private:
  [[noreturn]] void fail(const std::string& reason) const;

  std::string mFolder;  ///< for messages
  int mDescriptor = -1;
  std::int64_t mSize = 0;  ///< bytes
};

}  // namespace vdbtools
