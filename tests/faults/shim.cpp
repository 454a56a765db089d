// SPDX-License-Identifier: Apache-2.0
/// @file shim.cpp
/// A library to be preloaded, which makes calls of the C library fail. The tests say which by variables:
///
/// - FAULT=CALL:N:ERROR: the N-th call of that kind (from 1) fails with this errno, as in write:3:28
/// - FAULT=CALL:N+:ERROR: and so do all that follow
/// - FAULT=CALL:*:ERROR: every second call, so that whoever tries again gets through
/// - FAULT=bytes:N:ERROR: writing fails once N bytes are written, as on a disk that is full: what still fits goes in
/// - FAULT=short:*:0: every write takes half of what it is given
/// - FAULT=clock:*:0: the time of day goes forward and back by ten hours, from call to call
/// - FAULT=throw:N:0: while the N-th file is flushed, a thread throws an exception that nobody catches
/// - FAULT=crash:N:SIGNAL: while the N-th file is flushed, a thread gets this signal
/// - FAULT=stop:N:SIGNAL: while the N-th file is flushed, the process gets this signal; the flush takes two seconds
/// - FAULT=alloc:N:BYTES: the N-th allocation of at least so many bytes fails; N+ as above
/// - FAULT=space:N:ERROR: a mapping fails that would make more than N bytes of those that the libraries map themselves,
///   as under a limit of address space
/// - FAULT_PATH=FOLDER: only files below this folder are meant
/// - FAULT_COUNTS=FILE: an existing file of 8 bytes for each kind of call, which receives how often each was made
/// - FAULT_MEMINFO=FILE: is read in place of /proc/meminfo
///
/// The kinds are those of the list below. Files that the C library opens and reads by itself, as in fread(), are not
/// seen; the program and libstdc++ call open(), read() and write() themselves.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <thread>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

constexpr const char* kKinds[] = {"open",  "create", "read",  "write", "fsync",  "rename",
                                  "close", "unlink", "mkdir", "stat",  "random", "alloc"};
constexpr int kKindCount = sizeof kKinds / sizeof *kKinds;

enum Kind { Open, Create, Read, Write, Fsync, Rename, Close, Unlink, Mkdir, Stat, Random, Alloc };

enum class Mode { None, Once, FromThen, EverySecond };

struct Fault {
  int kind = -1;
  Mode mode = Mode::None;
  std::uint64_t at = 0;
  int error = 0;
  std::uint64_t least = 0;  ///< bytes of an allocation that counts
  bool bytes = false, isShort = false, clock = false, throws = false, crashes = false, stops = false, space = false;
  char folder[PATH_MAX] = {};
  std::size_t folderLength = 0;
};

Fault theFault;
std::atomic<std::uint64_t> theOwnCounts[kKindCount];
std::atomic<std::uint64_t>* theCounts = theOwnCounts;
std::atomic<std::uint64_t> theWritten{0}, theTimes{0}, theMapped{0};
std::atomic<bool> theReady{false};

template <class Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
#define REAL(name) static const auto call = real<decltype(&::name)>(#name)

__attribute__((constructor)) void begin() {
  if (const char* folder = getenv("FAULT_PATH")) {
    if (!realpath(folder, theFault.folder)) theFault.folder[0] = '\0';
    theFault.folderLength = std::strlen(theFault.folder);
  }
  if (const char* file = getenv("FAULT_COUNTS")) {
    const int descriptor = real<decltype(&::open)>("open")(file, O_RDWR | O_CLOEXEC);
    if (descriptor >= 0) {
      void* map = mmap(nullptr, sizeof theOwnCounts, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
      if (map != MAP_FAILED) theCounts = static_cast<std::atomic<std::uint64_t>*>(map);
      real<decltype(&::close)>("close")(descriptor);
    }
  }
  if (const char* text = getenv("FAULT")) {
    char kind[32] = {}, at[32] = {};
    unsigned long number = 0;
    if (std::sscanf(text, "%31[a-z]:%31[0-9*+]:%lu", kind, at, &number) == 3) {
      for (int k = 0; k < kKindCount; ++k)
        if (std::strcmp(kind, kKinds[k]) == 0) theFault.kind = k;
      theFault.bytes = std::strcmp(kind, "bytes") == 0;
      theFault.isShort = std::strcmp(kind, "short") == 0;
      theFault.clock = std::strcmp(kind, "clock") == 0;
      theFault.throws = std::strcmp(kind, "throw") == 0;
      theFault.crashes = std::strcmp(kind, "crash") == 0;
      theFault.stops = std::strcmp(kind, "stop") == 0;
      theFault.space = std::strcmp(kind, "space") == 0;
      if (theFault.throws || theFault.crashes || theFault.stops) theFault.kind = Fsync;
      theFault.at = std::strtoull(at, nullptr, 10);
      theFault.mode = std::strchr(at, '*') ? Mode::EverySecond : std::strchr(at, '+') ? Mode::FromThen : Mode::Once;
      theFault.error = static_cast<int>(number);
      if (theFault.kind == Alloc) {
        theFault.least = number;
        theFault.error = ENOMEM;
      }
    }
  }
  theReady = true;
}

/// Counts a call, and says whether it is to fail; errno is set then.
bool fails(Kind kind) {
  const std::uint64_t number = ++theCounts[kind];
  if (theFault.kind != kind) return false;
  const bool hit = theFault.mode == Mode::EverySecond ? number % 2 == 1
                   : theFault.mode == Mode::FromThen  ? number >= theFault.at
                                                      : number == theFault.at;
  if (hit && theFault.throws) std::thread([] { throw std::runtime_error("thrown by the shim"); }).join();
  if (hit && theFault.crashes) std::thread([] { std::raise(theFault.error); }).join();
  if (hit && theFault.stops) {
    kill(getpid(), theFault.error);
    std::this_thread::sleep_for(std::chrono::seconds(2));
    return false;
  }
  if (hit) errno = theFault.error;
  return hit;
}

bool isMeant(const char* path) {
  if (!theReady || theFault.folderLength == 0) return theReady;
  if (!path) return false;
  char whole[2 * PATH_MAX];
  if (path[0] != '/') {
    if (!getcwd(whole, PATH_MAX)) return false;
    std::strcat(whole, "/");
    const std::size_t length = std::strlen(path), at = std::strlen(whole);
    if (length >= PATH_MAX) return false;
    std::memcpy(whole + at, path, length + 1);
    path = whole;
  }
  return std::strncmp(path, theFault.folder, theFault.folderLength) == 0;
}

bool isMeant(int descriptor) {
  if (!theReady || theFault.folderLength == 0) return theReady;
  char link[64], path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const int before = errno;
  const ssize_t length = readlink(link, path, sizeof path - 1);
  errno = before;
  if (length < 0) return false;
  path[length] = '\0';
  return isMeant(path);
}

/// Bytes of @a size that may be written; -1: none, with errno.
ssize_t allowed(int descriptor, std::size_t size) {
  if (!isMeant(descriptor)) return static_cast<ssize_t>(size);
  if (fails(Write)) return -1;
  if (theFault.isShort && size > 1) size /= 2;
  if (theFault.bytes) {
    const std::uint64_t written = theWritten.fetch_add(size);
    if (written >= theFault.at) {
      errno = theFault.error;
      return -1;
    }
    size = static_cast<std::size_t>(std::min<std::uint64_t>(size, theFault.at - written));
  }
  return static_cast<ssize_t>(size);
}

std::time_t jump() {
  constexpr std::time_t kTenHours = 36000;
  return theFault.clock && theReady ? (theTimes++ % 2 == 0 ? kTenHours : -kTenHours) : 0;
}

bool allocationFails(std::size_t size) {
  if (!theReady || theFault.kind != Alloc || size < theFault.least) return false;
  return fails(Alloc);
}

const char* placeOf(const char* path) {
  const char* instead = getenv("FAULT_MEMINFO");
  return instead && std::strcmp(path, "/proc/meminfo") == 0 ? instead : path;
}

int openFails(const char* path, int flags) {
  return isMeant(path) &&
         fails((flags & (O_CREAT | O_TMPFILE)) != 0 && (flags & O_ACCMODE) != O_RDONLY ? Create : Open);
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list words;
  va_start(words, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(words, mode_t) : 0;
  va_end(words);
  if (openFails(path, flags)) return -1;
  REAL(open);
  return call(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list words;
  va_start(words, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(words, mode_t) : 0;
  va_end(words);
  if (openFails(path, flags)) return -1;
  REAL(open64);
  return call(path, flags, mode);
}

FILE* fopen(const char* path, const char* how) {
  if (openFails(path, how[0] == 'r' ? O_RDONLY : O_WRONLY | O_CREAT)) return nullptr;
  REAL(fopen);
  return call(placeOf(path), how);
}

FILE* fopen64(const char* path, const char* how) {
  if (openFails(path, how[0] == 'r' ? O_RDONLY : O_WRONLY | O_CREAT)) return nullptr;
  REAL(fopen64);
  return call(placeOf(path), how);
}

ssize_t read(int descriptor, void* to, std::size_t size) {
  if (isMeant(descriptor) && fails(Read)) return -1;
  REAL(read);
  return call(descriptor, to, size);
}

ssize_t pread64(int descriptor, void* to, std::size_t size, off64_t at) {
  if (isMeant(descriptor) && fails(Read)) return -1;
  REAL(pread64);
  return call(descriptor, to, size, at);
}

ssize_t pread(int descriptor, void* to, std::size_t size, off_t at) {
  if (isMeant(descriptor) && fails(Read)) return -1;
  REAL(pread);
  return call(descriptor, to, size, at);
}

ssize_t write(int descriptor, const void* from, std::size_t size) {
  const ssize_t part = allowed(descriptor, size);
  REAL(write);
  return part < 0 ? -1 : call(descriptor, from, static_cast<std::size_t>(part));
}

ssize_t pwrite(int descriptor, const void* from, std::size_t size, off_t at) {
  const ssize_t part = allowed(descriptor, size);
  REAL(pwrite);
  return part < 0 ? -1 : call(descriptor, from, static_cast<std::size_t>(part), at);
}

ssize_t pwrite64(int descriptor, const void* from, std::size_t size, off64_t at) {
  const ssize_t part = allowed(descriptor, size);
  REAL(pwrite64);
  return part < 0 ? -1 : call(descriptor, from, static_cast<std::size_t>(part), at);
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  std::size_t size = 0;
  for (int i = 0; i < count; ++i) size += parts[i].iov_len;
  const ssize_t part = allowed(descriptor, size);
  if (part < 0) return -1;
  if (static_cast<std::size_t>(part) == size) {
    REAL(writev);
    return call(descriptor, parts, count);
  }
  for (int i = 0; i < count; ++i)
    if (parts[i].iov_len > 0) {
      REAL(write);
      return call(descriptor, parts[i].iov_base, std::min(parts[i].iov_len, static_cast<std::size_t>(part)));
    }
  return 0;
}

int fsync(int descriptor) {
  if (isMeant(descriptor) && fails(Fsync)) return -1;
  REAL(fsync);
  return call(descriptor);
}

int close(int descriptor) {
  const bool failing = isMeant(descriptor) && fails(Close);
  const int error = errno;
  REAL(close);
  const int result = call(descriptor);
  if (!failing) return result;
  errno = error;  // Linux closes it all the same
  return -1;
}

int rename(const char* from, const char* to) {
  if (isMeant(to) && fails(Rename)) return -1;
  REAL(rename);
  return call(from, to);
}

int renameat2(int folder, const char* from, int other, const char* to, unsigned int flags) {
  if (isMeant(to) && fails(Rename)) return -1;
  REAL(renameat2);
  return call(folder, from, other, to, flags);
}

int unlink(const char* path) {
  if (isMeant(path) && fails(Unlink)) return -1;
  REAL(unlink);
  return call(path);
}

int mkdir(const char* path, mode_t mode) {
  if (isMeant(path) && fails(Mkdir)) return -1;
  REAL(mkdir);
  return call(path, mode);
}

int fstat(int descriptor, struct stat* status) {
  if (isMeant(descriptor) && fails(Stat)) return -1;
  REAL(fstat);
  return call(descriptor, status);
}

void* mmap(void* at, std::size_t size, int protection, int flags, int descriptor, off_t offset) {
  REAL(mmap);
  const bool counts = theReady && theFault.space && descriptor < 0;
  if (counts && theMapped.fetch_add(size) + size > theFault.at) {
    theMapped -= size;
    errno = theFault.error;
    return MAP_FAILED;
  }
  return call(at, size, protection, flags, descriptor, offset);
}

int munmap(void* at, std::size_t size) {
  REAL(munmap);
  if (theReady && theFault.space) theMapped -= std::min<std::uint64_t>(size, theMapped);
  return call(at, size);
}

ssize_t getrandom(void* to, std::size_t size, unsigned int flags) {
  if (theReady && fails(Random)) return -1;
  REAL(getrandom);
  return call(to, size, flags);
}

int clock_gettime(clockid_t clock, timespec* time) {
  REAL(clock_gettime);
  const int result = call(clock, time);
  if (clock == CLOCK_REALTIME) time->tv_sec += jump();
  return result;
}

int gettimeofday(timeval* time, void* zone) noexcept {
  static const auto call = reinterpret_cast<int (*)(timeval*, void*)>(dlsym(RTLD_NEXT, "gettimeofday"));
  const int result = call(time, zone);
  time->tv_sec += jump();
  return result;
}

std::time_t time(std::time_t* to) noexcept {
  static const auto call = reinterpret_cast<std::time_t (*)(std::time_t*)>(dlsym(RTLD_NEXT, "time"));
  const std::time_t result = call(nullptr) + jump();
  if (to) *to = result;
  return result;
}

void* malloc(std::size_t size) { return allocationFails(size) ? nullptr : __libc_malloc(size); }

void* calloc(std::size_t count, std::size_t size) {
  return allocationFails(count * size) ? nullptr : __libc_calloc(count, size);
}

void* realloc(void* from, std::size_t size) { return allocationFails(size) ? nullptr : __libc_realloc(from, size); }

void* memalign(std::size_t alignment, std::size_t size) {
  return allocationFails(size) ? nullptr : __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return allocationFails(size) ? nullptr : __libc_memalign(alignment, size);
}

int posix_memalign(void** to, std::size_t alignment, std::size_t size) {
  if (allocationFails(size)) return ENOMEM;
  *to = __libc_memalign(alignment, size);
  return *to ? 0 : ENOMEM;
}
}
