// SPDX-License-Identifier: Apache-2.0
/// @file temporaries.h
/// The temporary files of this process, and the locks by which other processes see whose owner lives.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>

namespace vdbtools {

/// What this process has to remove before it ends.
struct Registry {
  std::mutex mutex;
  std::map<std::filesystem::path, std::filesystem::path> targets;  ///< each with its target; empty for a MarkFile
  std::atomic<int> placing{0};         ///< calls of commitAll() that have come to the renames
  std::atomic<std::size_t> placed{0};  ///< files; written with the mutex held
};

/// Never destroyed, as files may be committed and removed while the process ends.
Registry& registry();

/// The first names that are tried for the temporary file of a target. They are the same in each process, so that what
/// a killed one left is found without looking through the folder.
inline constexpr std::uint32_t kUsualNames = 8;

/// A name that shows whose leftover it is, should the process be killed. @param number  below kUsualNames, or a random
/// one where these are taken
std::filesystem::path temporaryName(const std::filesystem::path& target, std::uint32_t number);

/// Removes the leftovers under the usual names of a target.
void removeLeftoversOf(const std::filesystem::path& target);

/// Locks a file that this process has just created, for as long as its descriptor or a duplicate of it is open. Where
/// the file system has no locks, nothing happens.
/// @return false if another process has removed it in between, taking it for a leftover
bool lockOwn(int descriptor, const std::filesystem::path& path);

enum class Owner {
  Alive,    ///< somebody holds the lock
  Dead,     ///< nobody on any machine does
  Unknown,  ///< nobody on this machine does, and the file system does not tell of others
};

/// Tries to lock an open file without waiting. @param lock  LOCK_EX or LOCK_SH
Owner ownerOf(int descriptor, int lock);

/// Removes a file whose owner is dead; where that cannot be known, one that nobody has written for a day. A file of
/// another process that takes the name at the same moment stays.
/// @return whether it is gone
bool removeIfLeftover(const std::filesystem::path& path);

}  // namespace vdbtools
