// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/file_bytes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/io_failure.h"
#include "vdbtools/files/standard_streams.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <vector>

namespace vdbtools {
namespace {

constexpr std::size_t kPieceSize = std::size_t{1} << 20;
constexpr std::size_t kLongestInMessage = 400;

[[noreturn]] void cannotOpen(const std::string& name, int error) {
  throw MissingInputError("cannot open " + name + ": " + errorText(error));
}

// A directory can be opened; only reading it would fail.
[[noreturn]] void isDirectory(const std::string& name) {
  throw MissingInputError("cannot read " + name + ": it is a directory; a file is needed");
}

/// An open file, closed with its scope.
class Input {
 public:
  explicit Input(const std::filesystem::path& path) : mName(inOneLine(path.native())) {
    const std::filesystem::path place = pathToOpen(path);
    do {
      mDescriptor = ::open(place.c_str(), O_RDONLY | O_CLOEXEC);
    } while (mDescriptor < 0 && errno == EINTR);
    if (mDescriptor < 0) cannotOpen(mName, errno);
    struct stat status {};
    if (::fstat(mDescriptor, &status) == 0) {
      if (S_ISDIR(status.st_mode)) {
        ::close(mDescriptor);
        isDirectory(mName);
      }
      if (S_ISREG(status.st_mode)) mSize = static_cast<std::size_t>(status.st_size);
    }
  }
  ~Input() { ::close(mDescriptor); }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  /// The size of a regular file when it was opened; 0 for others.
  std::size_t size() const { return mSize; }

  /// Reads up to @a size bytes into @a to; 0 at the end.
  std::size_t read(char* to, std::size_t size) {
    for (;;) {
      const ssize_t count = ::read(mDescriptor, to, size);
      if (count >= 0) return static_cast<std::size_t>(count);
      if (errno != EINTR) throwIoError("reading " + mName + " broke off", errno);
    }
  }

 private:
  std::string mName;
  int mDescriptor = -1;
  std::size_t mSize = 0;
};

}  // namespace

void readPieces(const std::filesystem::path& path, const std::function<void(std::string_view)>& use) {
  Input input(path);
  std::vector<char> buffer(kPieceSize);
  while (const std::size_t count = input.read(buffer.data(), buffer.size())) use({buffer.data(), count});
}

std::string readWholeFile(const std::filesystem::path& path) {
  Input input(path);
  requireMemory(static_cast<double>(input.size()), MemoryUse::File, inOneLine(path.native()));
  // One byte more than the file should hold, so that its end is detected without growing the buffer. A file that has
  // grown since, or has no size, is still read to its end.
  std::string content(input.size() + 1, '\0');
  std::size_t filled = 0;
  while (const std::size_t count = input.read(content.data() + filled, content.size() - filled)) {
    filled += count;
    if (filled == content.size()) content.resize(content.size() + std::max(content.size(), kPieceSize));
  }
  content.resize(filled);
  return content;
}

std::ifstream openToRead(const std::filesystem::path& path) {
  std::ifstream stream;
  const std::filesystem::path place = pathToOpen(path);
  do {
    errno = 0;
    stream.clear();
    stream.open(place, std::ios::binary);
  } while (!stream.is_open() && errno == EINTR);
  if (!stream.is_open()) cannotOpen(inOneLine(path.native()), errno);
  std::error_code ignored;
  if (std::filesystem::is_directory(place, ignored)) isDirectory(inOneLine(path.native()));
  return stream;
}

std::string withoutControls(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

std::string inOneLine(std::string_view text) {
  if (text.size() <= kLongestInMessage) return withoutControls(std::string(text));
  return withoutControls(std::string(text.substr(0, characterAt(text, kLongestInMessage)))) + "...";
}

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

std::string lowerExtension(const std::filesystem::path& path) { return lowerCase(path.extension().native()); }

}  // namespace vdbtools
