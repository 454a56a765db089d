// SPDX-License-Identifier: Apache-2.0
#include "files/mark_file.h"

#include "files/temporaries.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace vdbtools {
namespace {

MarkState stateOf(Owner owner) {
  return owner == Owner::Alive ? MarkState::Alive : owner == Owner::Dead ? MarkState::Dead : MarkState::Unknown;
}

}  // namespace

MarkFile::MarkFile(const std::filesystem::path& path, const std::string& content)
    : mFile(path), mPath(std::filesystem::absolute(path)) {
  mFile.stream() << content;
  Registry& live = registry();
  {
    const std::lock_guard lock(live.mutex);
    live.targets.try_emplace(mPath);
  }
  try {
    mFile.commit();
  } catch (...) {
    // It may have been committed already if flushing the folder failed.
    if (mFile.temporaryPath().empty()) ::unlink(mPath.c_str());
    const std::lock_guard lock(live.mutex);
    live.targets.erase(mPath);
    throw;
  }
}

MarkFile::~MarkFile() {
  Registry& live = registry();
  const std::lock_guard lock(live.mutex);
  if (live.targets.erase(mPath) > 0) ::unlink(mPath.c_str());
}

void MarkFile::touch() const noexcept {
  [[maybe_unused]] const int result = ::utimensat(AT_FDCWD, mPath.c_str(), nullptr, 0);
}

MarkState stateOfMark(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return errno == ENOENT ? MarkState::None : MarkState::Unknown;
  // A shared lock, so that two processes that ask at the same time do not take each other for the writer.
  const MarkState state = stateOf(ownerOf(descriptor, LOCK_SH));
  ::close(descriptor);
  return state;
}

void removeDeadMark(const std::filesystem::path& path) { removeIfLeftover(path); }

}  // namespace vdbtools
