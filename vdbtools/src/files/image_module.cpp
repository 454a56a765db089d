// SPDX-License-Identifier: Apache-2.0
#include "files/image_module.h"

#include "base/threads.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/files/atomic_file.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <string>
#include <thread>

namespace vdbtools {
namespace {

constexpr double kMebi = 1 << 20;

#ifdef JULIAVDB_IMAGE_MODULE
constexpr const char* kPictures = "pictures can be neither read nor written: ";
#endif

#if defined(JULIAVDB_IMAGE_MODULE) && !defined(VDBTOOLS_NO_PICTURES)
/// Some of the libraries crash while loading if memory is insufficient, so they are not loaded then.
void requireRoom(const MemoryLeft& left, double needed) {
  if (left.bytes < needed)
    throw MemoryError(std::string(kPictures) + "their libraries need some " + memoryText(needed) + ", but " +
                          left.limit + " leaves " + memoryText(left.bytes),
                      MemoryUse::Libraries);
}

/// The reason why the last call of the loader failed.
std::string reason() {
  const char* const text = dlerror();
  return text ? text : "the loader gives no reason";
}

/// Loads the module from the folder of this library.
void* loadModule() {
  Dl_info here{};
  if (dladdr(reinterpret_cast<const void*>(&imageFunction), &here) == 0 || !here.dli_fname)
    throw IoError(std::string(kPictures) + "the folder of this library is not known");
  const std::filesystem::path path = std::filesystem::path(here.dli_fname).parent_path() / JULIAVDB_IMAGE_MODULE;
  // While they load, the libraries of Debian 13 map 366 MiB, and 82 MiB of data; those of Debian 12 map 326 and 66. The
  // rest is a margin, in the proportion that served on Debian 12. One of them starts a thread per processor.
  constexpr double kSpace = 470 * kMebi, kData = 125 * kMebi, kStack = 8 * kMebi;
  const double stacks = kStack * std::thread::hardware_concurrency();
  requireRoom(addressSpaceLeft(), kSpace + stacks);
  requireRoom(dataLeft(), kData + stacks);
  std::atexit(removeTemporaries);  // one of them exits if its first allocation fails
  void* const module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module) return module;
  const std::string why = reason();
  if (why.ends_with("Cannot allocate memory")) throw std::bad_alloc();
  throw IoError(kPictures + why);
}
#endif

}  // namespace

#ifdef VDBTOOLS_NO_PICTURES
void* imageFunction(const char*) {
  throw IoError(kPictures + std::string("this program was built without: " VDBTOOLS_NO_PICTURES));
}
#elif defined(JULIAVDB_IMAGE_MODULE)
void* imageFunction(const char* name) {
  static void* const module = loadModule();
  void* const function = dlsym(module, name);
  if (!function) throw IoError(kPictures + reason());
  return function;
}
#endif

int imageThreads() {
  // OpenImageIO and OpenEXR start one thread each. For each, the C library reserves 64 MiB of addresses, briefly twice
  // as much, in addition to its stack.
  constexpr double kSpace = 2 * 136 * kMebi;
  return static_cast<int>(std::clamp<double>(addressSpaceLeft().bytes / kSpace, 1, allowedThreads()));
}

}  // namespace vdbtools
