// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/standard_streams.h"

#include "files/scratch_file.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/io_failure.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

constexpr std::size_t kInputPiece = std::size_t{1} << 20;

/// What takeStandardInput() has stored; nullptr before its first call. It lives as long as the process.
std::unique_ptr<ScratchFile>& storedInput() {
  static std::unique_ptr<ScratchFile> stored;
  return stored;
}

}  // namespace

void takeStandardInput() {
  if (storedInput()) return;
  struct stat status {};
  if (::fstat(STDIN_FILENO, &status) != 0)
    throw MissingInputError("the standard input cannot be read: " + errorText(errno));
  if (S_ISDIR(status.st_mode)) throw MissingInputError("the standard input is a folder; a file or a pipe is needed");
  if (::isatty(STDIN_FILENO) == 1)
    throw MissingInputError("the standard input is a terminal; redirect it from a file, or send a mesh through a pipe");
  auto stored = std::make_unique<ScratchFile>(scratchFolder());
  std::vector<char> piece(kInputPiece);
  for (;;) {
    const ssize_t count = ::read(STDIN_FILENO, piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throwIoError("reading the standard input broke off", errno);
    if (count == 0) break;
    stored->append({piece.data(), static_cast<std::size_t>(count)});
  }
  storedInput() = std::move(stored);
}

bool isStandardInput(const std::filesystem::path& path) { return storedInput() && path == kStandardStream; }

std::filesystem::path pathToOpen(const std::filesystem::path& path) {
  return isStandardInput(path) ? storedInput()->pathWhileOpen() : path;
}

}  // namespace vdbtools
