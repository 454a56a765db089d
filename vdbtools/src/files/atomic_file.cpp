// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/atomic_file.h"

#include "files/file_place.h"
#include "files/scratch_file.h"
#include "files/temporaries.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/io_failure.h"
#include "vdbtools/files/standard_streams.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferSize = std::size_t{1} << 20;
constexpr std::uint32_t kAttempts = 100;  ///< to find an unused name; the first nearly always succeeds

std::string nameOf(const fs::path& path) { return inOneLine(path.native()); }

[[noreturn]] void cannotCreate(const fs::path& path, const std::string& reason) {
  throw CreateError("cannot create " + nameOf(path) + ": " + reason);
}

/// Some file systems, and all pipes and terminals, do not support fsync.
bool isUnsupportedSync(int error) { return error == EINVAL || error == ENOSYS || error == EOPNOTSUPP; }

/// @return 0 or errno
int syncToDisk(int descriptor) {
  while (::fsync(descriptor) != 0) {
    if (errno == EINTR) continue;
    return isUnsupportedSync(errno) ? 0 : errno;
  }
  return 0;
}

template <class Call>
int openRetrying(Call call) {
  for (;;) {
    const int descriptor = call();
    if (descriptor >= 0 || errno != EINTR) return descriptor;
  }
}

/// Writes through a descriptor and stores the first error. Nothing is written after an error, so that a file with a gap
/// cannot pass for a complete one.
class DescriptorBuffer : public std::streambuf {
 public:
  DescriptorBuffer() : mBuffer(kBufferSize) {}
  ~DescriptorBuffer() override {
    if (mDescriptor >= 0) ::close(mDescriptor);
  }
  DescriptorBuffer(const DescriptorBuffer&) = delete;
  DescriptorBuffer& operator=(const DescriptorBuffer&) = delete;

  /// Takes over an open descriptor.
  void attach(int descriptor, bool seekable) {
    mDescriptor = descriptor;
    mSeekable = seekable;
    reset();
  }

  /// 0 or the errno of the first failure.
  int error() const { return mError; }

  /// Flushes, syncs and closes.
  void finish() {
    if (mDescriptor < 0 || !flushBuffer()) return;
    if (const int error = syncToDisk(mDescriptor)) {
      fail(error);
      return;
    }
    setp(nullptr, nullptr);
    const int descriptor = mDescriptor;
    mDescriptor = -1;
    // On Linux the descriptor is closed even if close() was interrupted.
    if (::close(descriptor) != 0 && errno != EINTR) fail(errno);
  }

 protected:
  int_type overflow(int_type c) override {
    if (!flushBuffer()) return traits_type::eof();
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    return sputc(traits_type::to_char_type(c));
  }

  std::streamsize xsputn(const char* from, std::streamsize size) override {
    if (size > epptr() - pptr()) {
      if (!flushBuffer()) return 0;
      // Large blocks go around the buffer.
      if (static_cast<std::size_t>(size) >= mBuffer.size()) {
        return writeAll(from, static_cast<std::size_t>(size)) ? size : 0;
      }
    }
    // memcpy() does not accept a null pointer, even for no bytes.
    std::copy_n(from, size, pptr());
    pbump(static_cast<int>(size));
    return size;
  }

  int sync() override {
    if (mDescriptor < 0 && mError == 0) return 0;
    return flushBuffer() ? 0 : -1;
  }

  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode which) override {
    if (!canSeek(which)) return failedSeek();
    off_type base = 0;
    if (from == std::ios_base::cur) {
      base = mPosition + (pptr() - pbase());
      if (offset == 0) return base;  // tellp() costs no write
    } else if (from == std::ios_base::end) {
      struct stat status {};
      if (!flushBuffer() || ::fstat(mDescriptor, &status) != 0) return failedSeek();
      base = status.st_size;
    }
    off_type position = 0;
    if (__builtin_add_overflow(base, offset, &position)) return failedSeek();
    return seekTo(position);
  }

  pos_type seekpos(pos_type position, std::ios_base::openmode which) override {
    return canSeek(which) ? seekTo(position) : failedSeek();
  }

 private:
  static pos_type failedSeek() { return pos_type(off_type(-1)); }

  bool canSeek(std::ios_base::openmode which) const {
    return mSeekable && mDescriptor >= 0 && mError == 0 && (which & std::ios_base::out) != 0;
  }

  pos_type seekTo(off_type position) {
    if (position < 0 || !flushBuffer()) return failedSeek();
    mPosition = position;
    return position;
  }

  void reset() { setp(mBuffer.data(), mBuffer.data() + mBuffer.size()); }

  void fail(int error) {
    mError = error;
    setp(nullptr, nullptr);  // so that every further write reaches overflow(), and fails
  }

  bool flushBuffer() {
    if (mError != 0 || mDescriptor < 0) return false;
    if (!writeAll(pbase(), static_cast<std::size_t>(pptr() - pbase()))) return false;
    reset();
    return true;
  }

  bool writeAll(const char* from, std::size_t size) {
    while (size > 0) {
      const ssize_t count = mSeekable ? ::pwrite(mDescriptor, from, size, mPosition) : ::write(mDescriptor, from, size);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        fail(count < 0 ? errno : EIO);
        return false;
      }
      from += count;
      size -= static_cast<std::size_t>(count);
      mPosition += count;
    }
    return true;
  }

  std::vector<char> mBuffer;
  int mDescriptor = -1;
  bool mSeekable = false;
  off_type mPosition = 0;  ///< position of the buffer's beginning in the file
  int mError = 0;
};

/// The target of a file after following its links.
struct Place {
  fs::path target;        ///< absolute, in a folder that exists
  bool replaces = true;   ///< false for devices and the like, which are written directly
  bool exists = false;    ///< as a regular file
  struct stat status {};  ///< of the existing file
};

Place placeOf(const fs::path& path) {
  Place place;
  place.target = path;
  place.exists = ::stat(path.c_str(), &place.status) == 0;
  if (!place.exists && errno != ENOENT) cannotCreate(path, errorText(errno));
  if (place.exists && S_ISDIR(place.status.st_mode)) cannotCreate(path, "it is a directory; give the name of a file");
  if (place.exists && !S_ISREG(place.status.st_mode)) {
    place.replaces = false;
    return place;
  }

  std::error_code error;
  const fs::path target = followLinks(path, error);
  if (error) cannotCreate(path, "its links cannot be followed: " + error.message());
  if (place.exists) {
    // Links below /proc may lead to files that no longer have a name.
    struct stat status {};
    if (::stat(target.c_str(), &status) != 0 || status.st_dev != place.status.st_dev ||
        status.st_ino != place.status.st_ino) {
      place.replaces = false;
      return place;
    }
    // A rename would replace it nevertheless.
    if (::faccessat(AT_FDCWD, target.c_str(), W_OK, AT_EACCESS) != 0) {
      cannotCreate(path, "the existing file may not be written: " + errorText(errno));
    }
  }
  if (!target.has_filename()) cannotCreate(path, "it does not name a file");

  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const fs::path canonicalFolder = fs::canonical(folder, error);
  if (error == std::errc::no_such_file_or_directory)
    cannotCreate(path, "there is no folder " + nameOf(folder) + "; make it first, by mkdir -p");
  if (error) cannotCreate(path, "its folder " + nameOf(folder) + " cannot be used: " + error.message());
  place.target = canonicalFolder / target.filename();
  return place;
}

/// Creates and registers the temporary file of @a place.
/// @param path  the original name, for messages
/// @return its descriptor
int createTemporary(const Place& place, const fs::path& path, fs::path& temporary) {
  Registry& live = registry();
  const std::lock_guard lock(live.mutex);
  for (const auto& [other, target] : live.targets) {
    if (target == place.target) cannotCreate(path, "this process is already writing it; give each output its own name");
  }
  removeLeftoversOf(place.target);
  for (std::uint32_t attempt = 0; attempt < kAttempts; ++attempt) {
    temporary = temporaryName(place.target, attempt < kUsualNames ? attempt : std::random_device()());
    const auto [entry, isNew] = live.targets.try_emplace(temporary, place.target);
    if (!isNew) continue;
    // Nobody else may read what replaces a private file; a new file gets the permissions given by the umask.
    const mode_t mode = place.exists ? S_IRUSR | S_IWUSR : 0666;
    const int descriptor =
        openRetrying([&] { return ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode); });
    if (descriptor >= 0 && lockOwn(descriptor, temporary)) return descriptor;
    const int error = descriptor >= 0 ? EEXIST : errno;
    if (descriptor >= 0) ::close(descriptor);
    live.targets.erase(entry);
    if (error != EEXIST)
      cannotCreate(path, "no file can be made in " + nameOf(temporary.parent_path()) + ": " + errorText(error));
  }
  cannotCreate(path, "no free name for a temporary file in " + nameOf(place.target.parent_path()));
}

void keepOwnerAndMode(int descriptor, const struct stat& status) {
  // Done as far as the process and the file system permit. A wrong owner does not justify a failure, but the old
  // group's permissions must not pass to another group.
  mode_t mode = status.st_mode & 0777;
  if (::fchown(descriptor, status.st_uid, status.st_gid) != 0 &&
      ::fchown(descriptor, static_cast<uid_t>(-1), status.st_gid) != 0) {
    mode &= ~static_cast<mode_t>(S_IRWXG);
  }
  [[maybe_unused]] const int result = ::fchmod(descriptor, mode);
}

/// How a rename is undone.
enum class Undo { Nothing, MoveBack, Exchange };

/// The lock of a file that is about to get a temporary name, which shows others that it is not a leftover.
class HeldLock {
 public:
  explicit HeldLock(const fs::path& path)
      : mDescriptor(::open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC)) {
    mHeld = mDescriptor >= 0 && ::flock(mDescriptor, LOCK_EX | LOCK_NB) == 0;
  }
  ~HeldLock() {
    if (mDescriptor >= 0) ::close(mDescriptor);
  }
  HeldLock(const HeldLock&) = delete;
  HeldLock& operator=(const HeldLock&) = delete;

  bool held() const { return mHeld; }

 private:
  int mDescriptor;
  bool mHeld;
};

/// Exchanges the names of two files. @return whether the system and the file system can do that, and it was done
bool exchange([[maybe_unused]] const fs::path& a, [[maybe_unused]] const fs::path& b) noexcept {
#ifdef RENAME_EXCHANGE
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
#else
  return false;
#endif
}

/// Renames @a temporary over @a target.
/// @param canUndo  keeps the replaced file, if the file system can
/// @param old      receives the lock of the replaced file, to be held while that has the temporary name. Without it
///                 another process would take the file for a leftover, and this process would then remove, by its name,
///                 the temporary file that the other process has created anew
/// @return 0 or errno
int replace(const fs::path& temporary, const fs::path& target, bool canUndo, Undo& undo,
            std::unique_ptr<const HeldLock>& old) {
  undo = Undo::Nothing;
  if (canUndo) {
    struct stat status {};
    if (::lstat(target.c_str(), &status) != 0) {
      if (errno == ENOENT) undo = Undo::MoveBack;
    } else if (S_ISREG(status.st_mode) && (old = std::make_unique<const HeldLock>(target))->held() &&
               exchange(temporary, target)) {
      undo = Undo::Exchange;
      return 0;
    }
  }
  return ::rename(temporary.c_str(), target.c_str()) == 0 ? 0 : errno;
}

void undoReplace(const fs::path& temporary, const fs::path& target, Undo undo) noexcept {
  if (undo == Undo::Nothing) return;
  // Nothing can be done if this fails; the current exception reports the first failure.
  if (undo == Undo::Exchange)
    exchange(target, temporary);
  else
    ::rename(target.c_str(), temporary.c_str());
}

/// @throw IoError  the folder's entries could not be flushed to the disk
void syncFolder(const fs::path& folder) {
  const int descriptor = openRetrying([&] { return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
  if (descriptor < 0) return;  // a folder may be writable, but not readable
  const int error = syncToDisk(descriptor);
  ::close(descriptor);
  if (error != 0) throwIoError("cannot flush the folder " + nameOf(folder) + " to the disk", error);
}

/// @param source  a descriptor of an ordinary file
void copyToStandardOutput(int source) {
  std::vector<char> piece(std::size_t{1} << 20);
  for (off_t at = 0;;) {
    const ssize_t count = ::pread(source, piece.data(), piece.size(), at);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throwIoError("reading the temporary file for the standard output failed", errno);
    if (count == 0) return;
    for (ssize_t done = 0; done < count;) {
      const ssize_t written = ::write(STDOUT_FILENO, piece.data() + done, static_cast<std::size_t>(count - done));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) throwIoError("writing to the standard output failed", written < 0 ? errno : EIO);
      done += written;
    }
    at += count;
  }
}

}  // namespace

struct AtomicFile::State {
  fs::path given, target, temporary;
  DescriptorBuffer buffer;
  std::ostream stream{&buffer};
  bool replaces = true;
  bool finished = false;
  bool committed = false;
  int copySource = -1;  ///< of the standard output: the bytes that deliver() copies there
  int lockHolder = -1;  ///< lock of the temporary file; the buffer's descriptor is closed before the file is committed

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    removeTemporary();
    if (copySource >= 0) ::close(copySource);
    if (lockHolder >= 0) ::close(lockHolder);
  }

  void removeTemporary() const {
    if (temporary.empty()) return;
    Registry& live = registry();
    const std::lock_guard lock(live.mutex);
    // It is not registered any more once it was committed, or removed by removeTemporaries().
    if (live.targets.erase(temporary) > 0) ::unlink(temporary.c_str());
  }

  void requireWritten() const {
    if (buffer.error() != 0) throwIoError("writing " + nameOf(given) + " failed", buffer.error());
    if (stream.fail()) throw IoError("writing " + nameOf(given) + " failed: its stream was left in a failed state");
  }
};

AtomicFile::AtomicFile(const fs::path& target) : mState(std::make_unique<State>()) {
  mState->given = target;
  const Place place = placeOf(target);
  mState->target = place.target;
  mState->replaces = place.replaces;
  if (!place.replaces) {
    const int descriptor = openRetrying([&] { return ::open(target.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC); });
    if (descriptor < 0) cannotCreate(target, errorText(errno));
    mState->buffer.attach(descriptor, false);
    return;
  }
  const int descriptor = createTemporary(place, target, mState->temporary);
  mState->buffer.attach(descriptor, true);
  mState->lockHolder = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  if (mState->lockHolder < 0) cannotCreate(target, errorText(errno));
  if (place.exists) keepOwnerAndMode(descriptor, place.status);
}

AtomicFile::AtomicFile() : mState(std::make_unique<State>()) {}

AtomicFile AtomicFile::standardOutput() {
  AtomicFile file;
  State& s = *file.mState;
  s.given = s.target = kStandardStream;
  s.replaces = false;
  if (::fcntl(STDOUT_FILENO, F_GETFD) < 0) cannotCreate("the standard output", errorText(errno));
  const fs::path folder = scratchFolder();
  const int descriptor = openNameless(folder);
  if (descriptor < 0)
    cannotCreate("the standard output", "no temporary file can be made in " + nameOf(folder) + ": " + errorText(errno));
  s.buffer.attach(descriptor, true);
  s.copySource = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  if (s.copySource < 0) cannotCreate("the standard output", errorText(errno));
  return file;
}

AtomicFile::~AtomicFile() = default;
AtomicFile::AtomicFile(AtomicFile&&) noexcept = default;
AtomicFile& AtomicFile::operator=(AtomicFile&&) noexcept = default;

AtomicFile::State& AtomicFile::state() const {
  if (!mState) throw std::logic_error("an AtomicFile was used after it was moved from");
  return *mState;
}

std::ostream& AtomicFile::stream() { return state().stream; }

void AtomicFile::finish() {
  State& s = state();
  if (s.finished) return;
  s.requireWritten();
  s.buffer.finish();
  s.requireWritten();
  s.finished = true;
}

void AtomicFile::deliver() {
  finish();
  State& s = state();
  if (s.copySource < 0) return;
  const int source = std::exchange(s.copySource, -1);
  struct Closed {
    ~Closed() { ::close(descriptor); }
    int descriptor;
  };
  const Closed closed{source};
  copyToStandardOutput(source);
}

void AtomicFile::commit() {
  AtomicFile* self = this;
  commitAll({&self, 1});
}

const fs::path& AtomicFile::target() const { return state().given; }

fs::path AtomicFile::temporaryPath() const {
  const State& s = state();
  return s.committed ? fs::path() : s.temporary;
}

void commitAll(std::span<AtomicFile* const> files) {
  std::vector<AtomicFile::State*> states;
  for (AtomicFile* file : files) {
    if (!file) throw std::logic_error("commitAll() was given a null pointer");
    AtomicFile::State& s = file->state();
    if (s.committed || std::find(states.begin(), states.end(), &s) != states.end()) {
      throw std::logic_error("the file " + nameOf(s.given) + " was committed twice");
    }
    states.push_back(&s);
  }
  for (AtomicFile* file : files) file->finish();
  for (AtomicFile* file : files) file->deliver();
  for (const AtomicFile::State* s : states) s->requireWritten();  // also after an earlier finish()

  std::set<fs::path> folders;
  for (const AtomicFile::State* s : states) {
    if (s->replaces) folders.insert(s->target.parent_path());
  }
  std::vector<Undo> undos(states.size(), Undo::Nothing);
  std::vector<std::unique_ptr<const HeldLock>> replaced(states.size());
  Registry& live = registry();
  struct Placing {
    explicit Placing(std::atomic<int>& number) : count(number) { ++count; }
    ~Placing() { --count; }
    std::atomic<int>& count;
  };
  const Placing placing(live.placing);
  {
    const std::lock_guard lock(live.mutex);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const AtomicFile::State& s = *states[i];
      if (!s.replaces) continue;
      // A temporary file that removeTemporaries() has removed cannot be renamed: ENOENT.
      const int error = replace(s.temporary, s.target, states.size() > 1, undos[i], replaced[i]);
      if (error == 0) continue;
      while (i-- > 0) undoReplace(states[i]->temporary, states[i]->target, undos[i]);
      throwIoError("cannot put " + nameOf(s.given) + " in its place", error);
    }
    for (std::size_t i = 0; i < states.size(); ++i) {
      AtomicFile::State& s = *states[i];
      // After an exchange, the temporary is the file that was replaced.
      if (undos[i] == Undo::Exchange) ::unlink(s.temporary.c_str());
      if (s.replaces) {
        live.targets.erase(s.temporary);
        ++live.placed;
      }
      s.committed = true;
    }
  }
  for (const fs::path& folder : folders) syncFolder(folder);
}

}  // namespace vdbtools
