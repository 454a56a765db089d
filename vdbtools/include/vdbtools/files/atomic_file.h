// SPDX-License-Identifier: Apache-2.0
/// @file atomic_file.h
/// Files that are never half written: a temporary file in the target's folder takes the bytes and is renamed over the
/// target once they are on the disk. Until then an existing target keeps its content.
///
///   AtomicFile file(path);    // fails here where the place is unwritable, not after hours of work
///   file.stream() << ...;
///   file.commit();
///
/// A symbolic link stays, and what it points to is replaced. An existing file's permissions are kept, and its owner
/// where this process may; a new file has those of any new file. A hard link to the old content keeps the old content.
/// Devices, pipes and the like cannot be replaced: they are opened and written directly, nothing of what was written to
/// them can be taken back, and there is no position in them. Writing to a pipe without a reader raises SIGPIPE.
#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <span>

namespace vdbtools {

class AtomicFile {
 public:
  /// Creates the temporary file.
  /// @throw CreateError  the place cannot be written: it is a directory, its folder is missing or read-only, the
  /// existing
  ///                     file is write-protected, or this process is already writing it
  explicit AtomicFile(const std::filesystem::path& target);

  /// Removes the temporary, unless it was committed.
  ~AtomicFile();

  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) noexcept;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Binary, with a buffer of 1 MiB. An error of writing sets badbit, stays, and comes out of finish(). tellp() and
  /// seekp() work, except in devices and pipes. The stream moves with this object: a reference to it stays valid.
  std::ostream& stream();

  /// Brings the bytes to the disk; afterwards the stream takes no more. Calls after the first do nothing.
  /// @throw IoError  something could not be written, now or earlier: a full disk, a lost mount
  void finish();

  /// Finishes if need be, renames the temporary over the target and brings the folder to the disk.
  /// @throw IoError           as finish(), or the rename failed
  /// @throw std::logic_error  it was committed already
  void commit();

  /// As it was given.
  const std::filesystem::path& target() const;

  /// Absolute; empty for devices and pipes, and once committed.
  std::filesystem::path temporaryPath() const;

 private:
  friend void commitAll(std::span<AtomicFile* const> files);
  struct State;
  State& state() const;
  std::unique_ptr<State> mState;
};

/// Commits several outputs of one job together: all are finished before the first is renamed, and where a later rename
/// fails the earlier ones are undone. Two things can part them: a crash between the renames, and a file system that
/// cannot exchange files (NFS), where a replaced file does not come back.
/// @throw as AtomicFile::commit()
void commitAll(std::span<AtomicFile* const> files);

/// Unlinks every temporary of this process: for its last moments, where destructors will not run. Files that are
/// committed later throw IoError. May be called from any thread, but not from a signal handler.
void removeTemporaries() noexcept;

}  // namespace vdbtools
