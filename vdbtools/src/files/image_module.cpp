// SPDX-License-Identifier: Apache-2.0
#include "files/image_module.h"

#ifdef JULIAVDB_IMAGE_MODULE
#include "vdbtools/base/errors.h"

#include <dlfcn.h>

#include <filesystem>
#include <string>

namespace vdbtools {
namespace {

/// Loads the module from the folder of this library.
void* loadModule() {
  Dl_info here{};
  if (dladdr(reinterpret_cast<const void*>(&imageFunction), &here) == 0 || !here.dli_fname)
    throw IoError("pictures can be neither read nor written: the folder of this library is not known");
  const std::filesystem::path path = std::filesystem::path(here.dli_fname).parent_path() / JULIAVDB_IMAGE_MODULE;
  return dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
}

}  // namespace

void* imageFunction(const char* name) {
  static void* const module = loadModule();
  void* const function = module ? dlsym(module, name) : nullptr;
  if (!function) throw IoError(std::string("pictures can be neither read nor written: ") + dlerror());
  return function;
}

}  // namespace vdbtools
#endif
