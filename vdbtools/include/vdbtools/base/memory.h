// SPDX-License-Identifier: Apache-2.0
/// @file memory.h
/// How much memory is left for this process, and the refusal of work that is known to need more.
///
/// Code that is about to allocate something large calls requireMemory() as soon as its size is known. The sizes that it
/// passes are lower bounds: refused work would not have fitted, but accepted work may still run out of memory.
#pragma once

#include <filesystem>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vdbtools {

/// What the memory is for. A front end can tell from it which options reduce the demand.
enum class MemoryUse {
  Distances,  ///< the distance field of a mesh
  Field,      ///< F on a lattice, and what is made from it
  Picture,    ///< a picture that is made
  Texture,    ///< a picture that is read
  File,       ///< a file that is read as a whole
  Libraries,  ///< the libraries for pictures, which are loaded with the first picture
};

/// Memory is short. Code that does not know this class handles it as a failed allocation.
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
  double bytes = 0;   ///< bytes that this process may still take; infinity: no limit is known
  std::string limit;  ///< the source of the limit, as in "the memory of this machine"
};

/// The smallest of the amounts that these limits leave:
///   the machine: what Linux calls available, and free swap space;
///   the control group of the process and its ancestors, version 1 or 2: their limit less what they hold, not counting
///   cached files, and their swap space;
///   the limits of address space and of data (ulimit -v, -d) less what the process uses of them.
/// @param root  where /proc and /sys are, for tests
MemoryLeft memoryLeft(const std::filesystem::path& root = "/");

/// As memoryLeft(), but without the limits of address space and of data and regardless of MemoryLimit: the memory
/// shared with other processes. Beyond it the system begins to swap, and then kills processes.
MemoryLeft sharedMemoryLeft(const std::filesystem::path& root = "/");

/// What the limit of address space (ulimit -v) leaves, regardless of MemoryLimit.
MemoryLeft addressSpaceLeft(const std::filesystem::path& root = "/");

/// What the limit of data (ulimit -d), i.e. of private writable memory, leaves, regardless of MemoryLimit.
MemoryLeft dataLeft(const std::filesystem::path& root = "/");

/// The total memory of this machine, bytes; infinity if the system does not report it. Unlike the free memory, it does
/// not change.
double machineMemory();

/// The resident memory of this process, bytes.
double residentMemory(const std::filesystem::path& root = "/");

/// The most memory that this process may have, bytes: the smallest MemoryLimit if there is one, even if the process has
/// more, and otherwise what it has and what memoryLeft() leaves. Estimates for the whole process compare with it.
double memoryInAll();

/// While one exists, it sets the total memory that the process may take, in place of the limits of memoryLeft(). If
/// several exist, e.g. in several threads, the smallest applies.
class MemoryLimit {
 public:
  /// @param bytes  infinity: no limit
  explicit MemoryLimit(double bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  double mBytes;
};

/// "16G" in bytes, with K, M, G or T; infinity for "unlimited"; nullopt for any other text.
std::optional<double> memoryFromText(std::string_view text);

/// The texts that memoryFromText() accepts, for messages.
inline constexpr const char* kMemoryTexts = "a number and K, M, G or T, such as 16G, or unlimited";

/// Detects that memory is running out. A process that takes the last of a machine's memory makes the machine hang and
/// is soon killed, so long work calls this several times a second.
/// @return what is wrong, once this process has taken much memory and almost none is left; nullopt before
std::optional<std::string> memoryRunsOut();

/// @param bytes  lower bound of what is needed in addition to what the process already has
/// @param what   what needs the memory, as in "the field"
/// @throw MemoryError  more than is left; the message gives both figures
void requireMemory(double bytes, MemoryUse use, const std::string& what);

/// The same for work whose size becomes known in small steps. Each call queries the system, so call it once for several
/// MiB.
void requireMemoryForStep(double bytes, MemoryUse use, const std::string& what);

/// "1.5 GiB"
std::string memoryText(double bytes);

}  // namespace vdbtools
