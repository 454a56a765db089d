// SPDX-License-Identifier: Apache-2.0
/// @file mark_file.h
/// A file that marks ongoing work, from which others can tell whether its writer is alive.
#pragma once

#include "vdbtools/files/atomic_file.h"

#include <filesystem>
#include <string>

namespace vdbtools {

/// The file exists as long as this object, unless the process is killed; removeTemporaries() removes it, too. It
/// replaces a file of that name, and is locked (flock) if the file system has locks.
class MarkFile {
 public:
  /// @throw CreateError, IoError  as AtomicFile
  MarkFile(const std::filesystem::path& path, const std::string& content);
  ~MarkFile();
  MarkFile(const MarkFile&) = delete;
  MarkFile& operator=(const MarkFile&) = delete;

  /// Sets the time of the file to now, as a sign of life for file systems whose locks do not reach other machines.
  void touch() const noexcept;

 private:
  AtomicFile mFile;  ///< holds the lock
  std::filesystem::path mPath;
};

enum class MarkState {
  Alive,    ///< its writer is alive
  Dead,     ///< its writer is gone
  Unknown,  ///< it is not locked, but its writer may live on another machine
  None,     ///< the file does not exist
};

MarkState stateOfMark(const std::filesystem::path& path);

/// Removes a mark whose writer is gone or, if that cannot be determined, one without a sign of life for a day.
void removeDeadMark(const std::filesystem::path& path);

}  // namespace vdbtools
