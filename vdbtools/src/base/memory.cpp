// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/memory.h"

#include "vdbtools/base/text.h"

#include <sys/resource.h>
#include <unistd.h>

#ifdef __EMSCRIPTEN__
#include <emscripten/emmalloc.h>
#include <emscripten/heap.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
constexpr double kKibi = 1024;

/// The values of all existing MemoryLimit objects.
struct Limits {
  std::mutex mutex;
  std::multiset<double> bytes;
};

Limits& limits() {
  // Never destroyed: limits may be read, and released, while the process ends.
  static Limits& theLimits = *new Limits;
  return theLimits;
}

std::optional<double> leastLimit() {
  Limits& all = limits();
  const std::lock_guard lock(all.mutex);
  return all.bytes.empty() ? std::nullopt : std::optional(*all.bytes.begin());
}

/// The number after "name" in a file of lines "name number", as in /proc/meminfo and memory.stat.
std::optional<double> entryOf(const fs::path& file, std::string_view name) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string word;
    double value = 0;
    if (words >> word && word == name && words >> value) return value;
  }
  return std::nullopt;
}

/// A file that holds a number, or "max".
std::optional<double> numberIn(const fs::path& file) {
  std::ifstream stream(file);
  std::string word;
  if (!(stream >> word)) return std::nullopt;
  if (word == "max") return kNoLimit;
  std::istringstream digits(word);
  double value = 0;
  if (!(digits >> value)) return std::nullopt;
  return value;
}

void limitBy(MemoryLeft& left, double bytes, const std::string& limit) {
  if (bytes < left.bytes) left = {std::max(0.0, bytes), limit};
}

/// The file names of a version of control groups.
struct GroupFiles {
  const char *limit, *usage, *ofFiles;
  const char *swapLimit, *swapUsage;
};
// Version 1 counts swap space together with memory.
constexpr GroupFiles kVersion2 = {"memory.max", "memory.current", "inactive_file", "memory.swap.max",
                                  "memory.swap.current"};
constexpr GroupFiles kVersion1 = {"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file", nullptr,
                                  nullptr};

void limitByGroup(MemoryLeft& left, const fs::path& folder, const GroupFiles& files, double swapFree) {
  const std::optional<double> limit = numberIn(folder / files.limit);
  const std::optional<double> usage = numberIn(folder / files.usage);
  if (!limit || !usage) return;
  const double ofFiles = entryOf(folder / "memory.stat", files.ofFiles).value_or(0);
  double swap = 0;
  if (files.swapLimit) {
    const double most = numberIn(folder / files.swapLimit).value_or(0);
    swap = std::clamp(most - numberIn(folder / files.swapUsage).value_or(0), 0.0, swapFree);
  }
  limitBy(left, *limit - std::max(0.0, *usage - ofFiles) + swap, "the control group of this process");
}

/// Applies the limits of the group of @a path and of all its ancestors. In a container the path may belong to another
/// name space; then the mount's root is the group.
void limitByGroups(MemoryLeft& left, const fs::path& mount, const std::string& path, const GroupFiles& files,
                   double swapFree) {
  std::error_code error;
  fs::path folder = fs::path(path).relative_path();
  for (;; folder = folder.parent_path()) {
    if (fs::exists(mount / folder, error)) limitByGroup(left, mount / folder, files, swapFree);
    if (folder.empty()) return;
  }
}

void limitByControlGroups(MemoryLeft& left, const fs::path& root, double swapFree) {
  const fs::path groups = root / "sys/fs/cgroup";
  std::ifstream stream(root / "proc/self/cgroup");
  // Lines are NUMBER:CONTROLLERS:PATH; version 2 has the number 0 and no controllers.
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::string path = line.substr(second + 1);
    if (controllers == ",,") {
      limitByGroups(left, groups, path, kVersion2, swapFree);
      limitByGroups(left, groups / "unified", path, kVersion2, swapFree);
    } else if (controllers.find(",memory,") != std::string::npos) {
      limitByGroups(left, groups / "memory", path, kVersion1, swapFree);
    }
  }
}

double ownMemory(const fs::path& root, const char* name) {
  return kKibi * entryOf(root / "proc/self/status", name).value_or(0);
}

/// @param own  the entry of /proc/self/status with the amount that the process uses
MemoryLeft leftOf(int resource, const fs::path& root, const char* own, const char* name) {
  MemoryLeft left{kNoLimit, "nothing"};
  rlimit limit{};
  if (getrlimit(static_cast<decltype(RLIMIT_AS)>(resource), &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    limitBy(left, static_cast<double>(limit.rlim_cur) - ownMemory(root, own), name);
  return left;
}

}  // namespace

double residentMemory(const fs::path& root) { return ownMemory(root, "VmRSS:"); }

MemoryLeft sharedMemoryLeft(const fs::path& root) {
  MemoryLeft left{kNoLimit, "nothing"};
  const fs::path machine = root / "proc/meminfo";
  const double swapFree = kKibi * entryOf(machine, "SwapFree:").value_or(0);
  if (const auto available = entryOf(machine, "MemAvailable:"))
    limitBy(left, kKibi * *available + swapFree, "the memory of this machine");
  limitByControlGroups(left, root, swapFree);
  return left;
}

MemoryLeft memoryLeft(const fs::path& root) {
  MemoryLeft left{kNoLimit, "nothing"};
  if (const std::optional<double> limit = leastLimit()) {
    limitBy(left, *limit - residentMemory(root), "the limit that was set");
    return left;
  }
  left = sharedMemoryLeft(root);
  for (const MemoryLeft& limit : {addressSpaceLeft(root), dataLeft(root)}) limitBy(left, limit.bytes, limit.limit);
  return left;
}

double memoryInAll() {
  const std::optional<double> limit = leastLimit();
  return limit ? *limit : memoryLeft().bytes + residentMemory();
}

MemoryLeft addressSpaceLeft([[maybe_unused]] const fs::path& root) {
#ifdef __EMSCRIPTEN__
  // What the allocator has been given back lies below the end of the heap, which never shrinks.
  return {static_cast<double>(emscripten_get_heap_max()) - static_cast<double>(emscripten_get_heap_size()) +
              static_cast<double>(emmalloc_free_dynamic_memory()),
          "the memory that WebAssembly has"};
#else
  return leftOf(RLIMIT_AS, root, "VmSize:", "the limit of address space (ulimit -v)");
#endif
}

MemoryLeft dataLeft(const fs::path& root) {
  return leftOf(RLIMIT_DATA, root, "VmData:", "the limit of data (ulimit -d)");
}

double machineMemory() {
  const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  return pages <= 0 || size <= 0 ? kNoLimit : static_cast<double>(pages) * static_cast<double>(size);
}

MemoryLimit::MemoryLimit(double bytes) : mBytes(bytes) {
  Limits& all = limits();
  const std::lock_guard lock(all.mutex);
  all.bytes.insert(bytes);
}

MemoryLimit::~MemoryLimit() {
  Limits& all = limits();
  const std::lock_guard lock(all.mutex);
  all.bytes.erase(all.bytes.find(mBytes));
}

std::optional<double> memoryFromText(std::string_view text) {
  if (text == "unlimited") return kNoLimit;
  constexpr std::string_view kUnits = "KMGT";
  const std::size_t unit = text.empty() ? std::string_view::npos : kUnits.find(text.back());
  if (unit == std::string_view::npos) return std::nullopt;
  const std::optional<double> value = numberFromText(text.substr(0, text.size() - 1));
  if (!value || !(*value > 0) || !std::isfinite(*value)) return std::nullopt;
  return std::ldexp(*value, 10 * static_cast<int>(unit + 1));
}

std::optional<std::string> memoryRunsOut() {
  constexpr double kLeastReserve = 32 << 20, kReserveShare = 0.01;  // bytes; fraction of the resident memory
  const double own = residentMemory();
  // A process that has not taken much is not to blame, and would free little.
  if (own < 16 * kLeastReserve) return std::nullopt;
  const MemoryLeft left = sharedMemoryLeft();
  if (left.bytes > std::max(kLeastReserve, kReserveShare * own)) return std::nullopt;
  return "memory is running out: this run has taken " + memoryText(own) + ", and " + left.limit + " leaves " +
         memoryText(left.bytes);
}

void requireMemory(double bytes, MemoryUse use, const std::string& what) {
  // Too little to ask the system.
  constexpr double kLittle = 8 * kKibi * kKibi;
  if (bytes >= kLittle) requireMemoryForStep(bytes, use, what);
}

void requireMemoryForStep(double bytes, MemoryUse use, const std::string& what) {
  const MemoryLeft left = memoryLeft();
  if (bytes <= left.bytes) return;
  throw MemoryError(what + " would take at least " + memoryText(bytes) + " of memory, but " + left.limit + " leaves " +
                        memoryText(left.bytes),
                    use);
}

std::string memoryText(double bytes) {
  constexpr std::array kUnits = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  std::size_t unit = 0;
  for (; bytes >= kKibi && unit + 1 < kUnits.size(); ++unit) bytes /= kKibi;
  char text[32];
  std::snprintf(text, sizeof text, bytes < 1000 ? "%.3g " : "%.4g ", bytes);
  return text + std::string(kUnits[unit]);
}

}  // namespace vdbtools
