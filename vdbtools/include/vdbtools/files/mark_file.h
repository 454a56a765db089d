// SPDX-License-Identifier: Apache-2.0
/// @file mark_file.h
/// A file that says that something is going on, and from which others can tell whether its writer lives.
#pragma once

#include "vdbtools/files/atomic_file.h"

#include <filesystem>
#include <string>

namespace vdbtools {

/// There as long as this object, unless the process is killed: removeTemporaries() removes it, too. It replaces a file
/// of that name, and is locked (flock) where the file system has locks.
class MarkFile {
 public:
  /// @throw CreateError, IoError  as AtomicFile
  MarkFile(const std::filesystem::path& path, const std::string& content);
  ~MarkFile();
  MarkFile(const MarkFile&) = delete;
  MarkFile& operator=(const MarkFile&) = delete;

  /// Sets the time of the file to now: a sign of life for file systems whose locks do not reach other machines.
  void touch() const noexcept;

 private:
  AtomicFile mFile;  ///< it holds the lock
  std::filesystem::path mPath;
};

enum class MarkState {
  Alive,    ///< its writer lives
  Dead,     ///< its writer is gone
  Unknown,  ///< it is not locked, but its writer may live on another machine
  None,     ///< there is no such file
};

MarkState stateOfMark(const std::filesystem::path& path);

/// Removes a mark whose writer is gone; where that cannot be known, one without a sign of life for a day.
void removeDeadMark(const std::filesystem::path& path);

}  // namespace vdbtools
