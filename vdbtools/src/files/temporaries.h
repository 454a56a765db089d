// SPDX-License-Identifier: Apache-2.0
/// @file temporaries.h
/// The temporary files of this process, and the locks that show other processes whether their owner is alive.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>

namespace vdbtools {

/// What this process must remove before it ends.
struct Registry {
  std::mutex mutex;
  std::map<std::filesystem::path, std::filesystem::path> targets;  ///< target of each file; empty for a MarkFile
  std::atomic<int> placing{0};         ///< number of commitAll() calls that are renaming files
  std::atomic<std::size_t> placed{0};  ///< number of files; written with the mutex held
};

/// Never destroyed, because files may be committed and removed while the process ends.
Registry& registry();

/// The first names that are tried for the temporary file of a target. They are the same in every process, so leftovers
/// of a killed process are found without searching the folder.
inline constexpr std::uint32_t kUsualNames = 8;

/// A name that identifies its target if the process is killed. @param number  below kUsualNames, or a random number if
/// those are taken
std::filesystem::path temporaryName(const std::filesystem::path& target, std::uint32_t number);

/// Removes the leftovers under the usual names of a target.
void removeLeftoversOf(const std::filesystem::path& target);

/// Locks a file that this process has just created, for as long as its descriptor or a duplicate of it is open. Does
/// nothing if the file system has no locks.
/// @return false if another process has removed it in between as a supposed leftover
bool lockOwn(int descriptor, const std::filesystem::path& path);

enum class Owner {
  Alive,    ///< some process holds the lock
  Dead,     ///< no process on any machine holds it
  Unknown,  ///< no process on this machine holds it; the file system cannot tell about other machines
};

/// Tries to lock an open file without waiting. @param lock  LOCK_EX or LOCK_SH
Owner ownerOf(int descriptor, int lock);

/// Removes a file whose owner is dead or, if that cannot be determined, one that has not been written for a day. A file
/// of another process that takes the name at the same moment stays.
/// @return whether the file is gone
bool removeIfLeftover(const std::filesystem::path& path);

}  // namespace vdbtools
