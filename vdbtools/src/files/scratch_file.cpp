// SPDX-License-Identifier: Apache-2.0
#include "files/scratch_file.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/io_failure.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <ostream>
#include <string>
#include <system_error>
#include <vector>

namespace vdbtools {
namespace {

constexpr std::size_t kCopiedAtOnce = std::size_t{1} << 20;

}  // namespace

int openNameless(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (descriptor >= 0) return descriptor;
  // Not every file system supports unnamed files (overlayfs and NFS do not); otherwise the name is removed at once.
  std::string name = (folder / ".juliavdb.XXXXXX").native();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

std::filesystem::path scratchFolder() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (error) throw CreateError("there is no folder for temporary files: TMPDIR names none that can be used");
  return folder;
}

ScratchFile::ScratchFile(const std::filesystem::path& folder) {
  const std::filesystem::path place = folder.empty() ? "." : folder;
  mFolder = inOneLine(place.native());
  mDescriptor = openNameless(place);
  if (mDescriptor < 0) throw CreateError("cannot create a temporary file in " + mFolder + ": " + errorText(errno));
}

ScratchFile::~ScratchFile() { ::close(mDescriptor); }

void ScratchFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(mDescriptor, bytes.data(), bytes.size(), mSize);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("cannot be written: " + errorText(count < 0 ? errno : EIO));
    bytes.remove_prefix(static_cast<std::size_t>(count));
    mSize += count;
  }
}

void ScratchFile::moveTo(std::ostream& stream) {
  std::vector<char> piece(kCopiedAtOnce);
  for (std::int64_t at = 0; at < mSize && stream;) {
    const ssize_t count = ::pread(mDescriptor, piece.data(), piece.size(), at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("cannot be read: " + (count < 0 ? errorText(errno) : "it ends at byte " + std::to_string(at)));
    stream.write(piece.data(), count);
#ifndef __EMSCRIPTEN__
    // Avoids two copies on the disk. If the file system cannot do this, nothing is lost.
    [[maybe_unused]] const int result = ::fallocate(mDescriptor, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, at, count);
#endif
    at += count;
  }
}

std::filesystem::path ScratchFile::pathWhileOpen() const { return "/proc/self/fd/" + std::to_string(mDescriptor); }

void ScratchFile::fail(const std::string& reason) const {
  throw IoError("a temporary file in " + mFolder + " " + reason);
}

}  // namespace vdbtools
