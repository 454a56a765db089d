// SPDX-License-Identifier: Apache-2.0
#include "files/temporaries.h"

#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/input_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <string_view>
#include <system_error>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

/// The number of bytes of the target's name in the temporary's, so that the latter is not too long if the former fits.
constexpr std::size_t kLongestStem = 100;
constexpr std::string_view kSuffix = ".tmp";
constexpr std::size_t kDigits = 8;
/// If locks do not tell, a temporary file that has not been written for this long, in seconds, is a leftover.
constexpr std::time_t kOld = 24 * 60 * 60;

/// File systems on which a free lock means that no process on any machine holds it (statfs(2)): local ones, and those
/// whose clients share locks unless mounted otherwise.
constexpr std::array<std::uint32_t, 13> kWithSharedLocks = {
    0x0000EF53,  // ext2 to ext4
    0x58465342,  // XFS
    0x9123683E,  // Btrfs
    0x2FC12FC1,  // ZFS
    0xF2F52010,  // F2FS
    0xCA451A4E,  // bcachefs
    0x01021994,  // tmpfs
    0x858458F6,  // ramfs
    0x794C7630,  // overlayfs
    0x00006969,  // NFS
    0x00C36400,  // Ceph
    0x47504653,  // GPFS
    0x01161970,  // GFS2
};

int lockRetrying(int descriptor, int operation) {
  for (;;) {
    const int result = ::flock(descriptor, operation);
    if (result == 0 || errno != EINTR) return result;
  }
}

/// Whether @a path still refers to the open file.
bool leadsTo(const fs::path& path, int descriptor) {
  struct stat open {
  }, named{};
  return ::fstat(descriptor, &open) == 0 && ::lstat(path.c_str(), &named) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

/// ".name.01234567.tmp"
bool isTemporaryName(std::string_view name) {
  if (name.size() < 1 + 1 + kDigits + kSuffix.size() || name.front() != '.' || !name.ends_with(kSuffix)) return false;
  name.remove_suffix(kSuffix.size());
  const std::string_view digits = name.substr(name.size() - kDigits);
  return name[name.size() - kDigits - 1] == '.' && std::all_of(digits.begin(), digits.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

}  // namespace

Registry& registry() {
  static Registry& instance = *new Registry;
  return instance;
}

PlacedFiles placedFiles() noexcept {
  const Registry& live = registry();
  return {.now = live.placing > 0, .count = live.placed};
}

fs::path temporaryName(const fs::path& target, std::uint32_t number) {
  const std::string name = target.filename().native();
  // Distinguishes two long names with the same beginning.
  const auto own = static_cast<std::uint32_t>(std::hash<std::string>()(name));
  char suffix[16];
  std::snprintf(suffix, sizeof suffix, ".%08x.tmp", static_cast<unsigned int>(own + number));
  return target.parent_path() / ("." + name.substr(0, kLongestStem) + suffix);
}

void removeLeftoversOf(const fs::path& target) {
  for (std::uint32_t number = 0; number < kUsualNames; ++number) removeIfLeftover(temporaryName(target, number));
}

bool lockOwn(int descriptor, const fs::path& path) {
  if (lockRetrying(descriptor, LOCK_EX) != 0) return true;
  return leadsTo(path, descriptor);
}

Owner ownerOf(int descriptor, int lock) {
  if (lockRetrying(descriptor, lock | LOCK_NB) != 0) return errno == EWOULDBLOCK ? Owner::Alive : Owner::Unknown;
  struct statfs status {};
  if (::fstatfs(descriptor, &status) != 0) return Owner::Unknown;
  const auto type = static_cast<std::uint32_t>(status.f_type);
  const bool shared = std::find(kWithSharedLocks.begin(), kWithSharedLocks.end(), type) != kWithSharedLocks.end();
  return shared ? Owner::Dead : Owner::Unknown;
}

bool removeIfLeftover(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return false;
  struct stat status {};
  bool leftover = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  if (leftover) {
    const Owner owner = ownerOf(descriptor, LOCK_EX);
    leftover = owner == Owner::Dead || (owner == Owner::Unknown && std::time(nullptr) - status.st_mtime > kOld);
  }
  // The lock is held until the file is removed: a process that has just created it waits for the lock, and then detects
  // this.
  const bool removed = leftover && leadsTo(path, descriptor) && ::unlink(path.c_str()) == 0;
  ::close(descriptor);
  return removed;
}

std::size_t sweepTemporaries(const fs::path& folder) {
  std::size_t count = 0;
  std::error_code error;
  const fs::directory_iterator end;
  for (fs::directory_iterator entry(folder, error); !error && entry != end; entry.increment(error))
    if (isTemporaryName(entry->path().filename().native()) && removeIfLeftover(entry->path())) ++count;
  return count;
}

void removeTemporaries() noexcept {
  Registry& live = registry();
  const std::lock_guard lock(live.mutex);
  for (const auto& [temporary, target] : live.targets) ::unlink(temporary.c_str());
  live.targets.clear();
}

}  // namespace vdbtools
