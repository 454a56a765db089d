// SPDX-License-Identifier: Apache-2.0
/// @file memory.h
/// How much memory is left for this process, and the refusal of work that is known to need more.
///
/// Whoever is about to make something large calls requireMemory() as soon as its size is known. The sizes that it is
/// given are low: work that is refused would not have fitted, but not all that fits is known beforehand.
#pragma once

#include <filesystem>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vdbtools {

/// What takes the memory, for whoever knows the options that make it smaller.
enum class MemoryUse {
  Distances,  ///< the distance field of a mesh
  Field,      ///< F on a lattice, and what is made of it
  Picture,    ///< one that is made
  Texture,    ///< one that is read
  File,       ///< that is read whole
  Libraries,  ///< for pictures, which are loaded with the first of them
};

/// Memory is short. To whoever does not know better, it is a failed allocation.
class MemoryError : public std::bad_alloc {
 public:
  MemoryError(std::string what, MemoryUse use) : mWhat(std::move(what)), mUse(use) {}
  const char* what() const noexcept override { return mWhat.c_str(); }
  MemoryUse use() const { return mUse; }

 private:
  std::string mWhat;
  MemoryUse mUse;
};

struct MemoryLeft {
  double bytes = 0;   ///< that this process may still take; infinity: no limit is known
  std::string limit;  ///< what sets it, as in "the memory of this machine"
};

/// The least of what these leave:
///   the machine: what Linux calls available, and free swap space;
///   the control group of the process and those above it, version 1 or 2: their limit less what they hold without the
///   part of it that is kept of files, and their swap space;
///   the limits of address space and of data (ulimit -v, -d) less what the process takes of them.
/// @param root  where /proc and /sys are, for tests
MemoryLeft memoryLeft(const std::filesystem::path& root = "/");

/// The same without the limits of address space and of data, whatever MemoryLimit says: what is shared with other
/// processes. Past it the system begins to move memory to and fro, and then kills processes.
MemoryLeft sharedMemoryLeft(const std::filesystem::path& root = "/");

/// What the limit of address space (ulimit -v) leaves of it, whatever MemoryLimit says.
MemoryLeft addressSpaceLeft(const std::filesystem::path& root = "/");

/// The same of data (ulimit -d): of memory that is not shared and can be written.
MemoryLeft dataLeft(const std::filesystem::path& root = "/");

/// All that this machine has, bytes; infinity if the system does not say. What of it is free changes from moment to
/// moment.
double machineMemory();

/// What this process has in memory, bytes.
double residentMemory(const std::filesystem::path& root = "/");

/// While one exists, this is what the process may take in all, in place of the limits of memoryLeft(). Of several, as
/// of work in several threads, the least counts.
class MemoryLimit {
 public:
  /// @param bytes  infinity: all is tried
  explicit MemoryLimit(double bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  double mBytes;
};

/// "16G" in bytes, with K, M, G or T; infinity for "unlimited"; nothing for any other text.
std::optional<double> memoryFromText(std::string_view text);

/// What memoryFromText() takes, for messages.
inline constexpr const char* kMemoryTexts = "a number and K, M, G or T, such as 16G, or unlimited";

/// Whoever takes the last of a machine's memory makes it stand still, and is killed before long. To be asked some times
/// a second while work goes on.
/// @return what is wrong, once this process has taken much and next to nothing is left; nothing before
std::optional<std::string> memoryRunsOut();

/// @param bytes  that are needed at least, beside what the process has
/// @param what   would take them, as in "the field"
/// @throw MemoryError  more than is left; with both figures
void requireMemory(double bytes, MemoryUse use, const std::string& what);

/// "1.5 GiB"
std::string memoryText(double bytes);

}  // namespace vdbtools
