// SPDX-License-Identifier: Apache-2.0
#include "files/file_state.h"

#include "vdbtools/files/standard_streams.h"

#include <sys/stat.h>

namespace vdbtools {

FileState stateOf(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(pathToOpen(file).c_str(), &status) != 0) return {};
  const auto nanoseconds = [](const timespec& time) {
    return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
  };
  return {.device = status.st_dev,
          .number = status.st_ino,
          .bytes = static_cast<std::uint64_t>(status.st_size),
          .modified = nanoseconds(status.st_mtim),
          .changed = nanoseconds(status.st_ctim)};
}

}  // namespace vdbtools
