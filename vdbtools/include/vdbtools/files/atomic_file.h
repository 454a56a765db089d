// SPDX-License-Identifier: Apache-2.0
/// @file atomic_file.h
/// Files that are never left half written: the bytes go to a temporary file in the target's folder, which is renamed
/// over the target once they are on the disk. Until then an existing target keeps its content.
///
///   AtomicFile file(path);    // fails here where the place is unwritable, not after hours of work
///   file.stream() << ...;
///   file.commit();
///
/// A symbolic link stays a link, and the file that it points to is replaced. An existing file keeps its permissions,
/// and its owner if this process may set it; a new file gets the usual permissions. Other hard links to an existing
/// file keep the old content. Devices, pipes and the like cannot be replaced: they are opened and written directly,
/// written data cannot be undone, and they have no position. Writing to a pipe without a reader raises SIGPIPE.
///
/// A killed process leaves its temporary files behind. The next process that writes the same file removes them, and
/// sweepTemporaries() removes those of a whole folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <ostream>
#include <span>

namespace vdbtools {

class AtomicFile {
 public:
  /// Creates the temporary file.
  /// @throw CreateError  the target cannot be written: it is a directory, its folder is missing or read-only, it exists
  ///                     and is write-protected, or this process is already writing it
  explicit AtomicFile(const std::filesystem::path& target);

  /// In the place of a file, the standard output. The bytes go to an unnamed temporary file, which deliver() copies, so
  /// that nothing reaches the standard output unless all work before has succeeded. The target is called "-".
  /// @throw CreateError  no temporary file can be created, or the standard output is closed
  static AtomicFile standardOutput();

  /// Removes the temporary file, unless it was committed.
  ~AtomicFile();

  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) noexcept;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// A binary stream with a buffer of 1 MiB. A write error sets badbit permanently, and finish() throws it. tellp() and
  /// seekp() work, except on devices and pipes. A reference to the stream stays valid when this object is moved.
  std::ostream& stream();

  /// Flushes the bytes to the disk; the stream accepts no more after that. Calls after the first do nothing.
  /// @throw IoError  something could not be written, now or earlier, e.g. because of a full disk or a lost mount
  void finish();

  /// Copies the finished bytes to the standard output, if that is the target; else it does nothing. Calls after the
  /// first do nothing.
  /// @throw IoError  e.g. because the reader of a pipe is gone
  void deliver();

  /// Calls finish() and deliver() if necessary, renames the temporary file over the target and flushes the folder to
  /// the disk.
  /// @throw IoError           as finish(), or the rename failed
  /// @throw std::logic_error  the file was committed already
  void commit();

  /// The target as given to the constructor.
  const std::filesystem::path& target() const;

  /// An absolute path; empty for devices and pipes, and after the commit.
  std::filesystem::path temporaryPath() const;

 private:
  AtomicFile();
  friend void commitAll(std::span<AtomicFile* const> files);
  struct State;
  State& state() const;
  std::unique_ptr<State> mState;
};

/// Commits several outputs of one job together: all are finished before the first is renamed, and if a later rename
/// fails, the earlier ones are undone. Only two events can leave some of them committed: a crash between the renames,
/// or a failure on a file system that cannot exchange files (NFS), where a replaced file is lost.
/// @throw as AtomicFile::commit()
void commitAll(std::span<AtomicFile* const> files);

/// Unlinks every temporary file of this process. It serves a process that is about to end without running destructors.
/// Committing a file later throws IoError. May be called from any thread, but not from a signal handler.
void removeTemporaries() noexcept;

/// Removes from @a folder the temporary files of killed processes. The owner of a temporary file holds a lock on it
/// (flock), which ends with the process. On file systems whose locks do not reach other machines, only files that have
/// not been written for a day are removed. Files that cannot be read or removed stay.
/// @return the number of removed files
std::size_t sweepTemporaries(const std::filesystem::path& folder);

}  // namespace vdbtools
