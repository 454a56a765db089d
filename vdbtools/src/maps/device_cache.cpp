// SPDX-License-Identifier: Apache-2.0
#include "maps/device_cache.h"

#include "vdbtools/files/named_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFirstLine = "juliavdb device cache 1\n";
constexpr const char* kEnding = ".program";
constexpr std::size_t kMostFiles = 128;                   // the oldest ones go
constexpr std::size_t kMostBytes = std::size_t{1} << 26;  // of a file

/// An open file or folder.
class Descriptor {
 public:
  explicit Descriptor(int number) : mNumber(number) {}
  Descriptor(const Descriptor&) = delete;
  ~Descriptor() {
    if (mNumber >= 0) close(mNumber);
  }
  int get() const { return mNumber; }
  explicit operator bool() const { return mNumber >= 0; }

 private:
  int mNumber;
};

/// Whether this user owns it, and nobody else may write to it.
bool isOwnAlone(int descriptor, mode_t kind) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 && (status.st_mode & S_IFMT) == kind && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

class FolderCache final : public julia::DeviceCache {
 public:
  explicit FolderCache(fs::path folder) : mFolder(std::move(folder)) {}

  std::string find(const std::string& key) const override {
    const std::string hash = sha256Hex(key);
    const Descriptor folder = opened();
    if (!folder) return {};
    const Descriptor file(
        openat(folder.get(), (hash + kEnding).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (!file || !isOwnAlone(file.get(), S_IFREG)) return {};
    const std::string text = contentOf(file.get()), head = kFirstLine + hash + "\n";
    constexpr std::size_t kHashLine = 65;
    if (!text.starts_with(head) || text.size() < head.size() + kHashLine) return {};
    std::string data = text.substr(head.size() + kHashLine);
    if (text.compare(head.size(), kHashLine, sha256Hex(data) + "\n") != 0) return {};
    return data;
  }

  void keep(const std::string& key, const std::string& data) const override {
    if (data.size() > kMostBytes) return;
    const std::string hash = sha256Hex(key), text = kFirstLine + hash + "\n" + sha256Hex(data) + "\n" + data;
    const Descriptor folder = opened();
    if (!folder) return;
    static std::atomic<int> number{0};
    const std::string part = hash + "." + std::to_string(getpid()) + "." + std::to_string(number++) + ".part";
    {
      const Descriptor file(
          openat(folder.get(), part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
      if (!file) return;
      for (std::size_t at = 0; at < text.size();) {
        const ssize_t written = write(file.get(), text.data() + at, text.size() - at);
        if (written <= 0) {
          unlinkat(folder.get(), part.c_str(), 0);
          return;
        }
        at += static_cast<std::size_t>(written);
      }
    }
    if (renameat(folder.get(), part.c_str(), folder.get(), (hash + kEnding).c_str()) != 0)
      unlinkat(folder.get(), part.c_str(), 0);
    removeOldest();
  }

  /// Makes the folder, and those above it. @return whether it is there and safe
  bool make() const {
    std::error_code error;
    fs::create_directories(mFolder.parent_path(), error);
    mkdir(mFolder.c_str(), S_IRWXU);
    return static_cast<bool>(opened());
  }

 private:
  /// The folder, if it is safe; else no descriptor.
  Descriptor opened() const {
    const int folder = open(mFolder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0 || isOwnAlone(folder, S_IFDIR)) return Descriptor(folder);
    close(folder);
    return Descriptor(-1);
  }

  static std::string contentOf(int file) {
    std::string text;
    std::vector<char> part(std::size_t{1} << 16);
    for (;;) {
      const ssize_t size = read(file, part.data(), part.size());
      if (size < 0 || text.size() > 2 * kMostBytes) return {};
      if (size == 0) return text;
      text.append(part.data(), static_cast<std::size_t>(size));
    }
  }

  /// Files that another process removes at the same time are no failure.
  void removeOldest() const {
    std::error_code error;
    std::vector<std::pair<fs::file_time_type, fs::path>> files;
    for (fs::directory_iterator it(mFolder, error), end; !error && it != end; it.increment(error)) {
      std::error_code gone;
      const auto time = fs::last_write_time(it->path(), gone);
      const auto ending = it->path().extension();
      if (!gone && (ending == kEnding || ending == ".part")) files.emplace_back(time, it->path());
    }
    if (files.size() <= kMostFiles) return;
    std::sort(files.begin(), files.end());
    for (std::size_t i = 0; i + kMostFiles < files.size(); ++i) fs::remove(files[i].second, error);
  }

  fs::path mFolder;
};

std::string variableOr(const char* name, const std::string& otherwise) {
  const char* const text = std::getenv(name);
  return text && *text ? text : otherwise;
}

/// Empty if there is none.
fs::path cacheFolder() {
  const std::string named = variableOr("JULIAVDB_DEVICE_CACHE", "");
  if (!named.empty()) return named == "none" ? fs::path() : fs::absolute(named);
  // As the specification of XDG's base directories has it: a path that is not absolute does not count.
  const fs::path cache = variableOr("XDG_CACHE_HOME", "");
  if (cache.is_absolute()) return cache / "juliavdb" / "devices";
  const fs::path home = variableOr("HOME", "");
  return home.is_absolute() ? home / ".cache" / "juliavdb" / "devices" : fs::path();
}

}  // namespace

std::shared_ptr<const julia::DeviceCache> deviceCache() {
  const fs::path folder = cacheFolder();
  if (folder.empty()) return nullptr;
  auto cache = std::make_shared<const FolderCache>(folder);
  return cache->make() ? cache : nullptr;
}

}  // namespace vdbtools
