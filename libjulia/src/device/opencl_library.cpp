// SPDX-License-Identifier: Apache-2.0
#include "device/opencl_library.h"

#include <dlfcn.h>

#include <cstdlib>
#include <string>
#include <type_traits>

namespace julia::device {
namespace {

struct Loaded {
  OpenClFunctions functions;
  std::string refusal;

  Loaded() {
    const char* const named = std::getenv("JULIAVDB_OPENCL");
    const std::string loader = named && *named ? named : "libOpenCL.so.1";
    // Stays open until the process ends: drivers do not survive being unloaded.
    void* const library = dlopen(loader.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      refusal = "OpenCL's loader " + loader +
                " was not found; on Debian, install ocl-icd-libopencl1, or set JULIAVDB_OPENCL to its file";
      return;
    }
    const auto find = [&](const char* name, auto& function) {
      void* const address = dlsym(library, name);
      if (!address && refusal.empty()) refusal = loader + " has no function " + name;
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(address);
    };
#define JULIA_OPENCL_FIND(name) find("cl" #name, functions.name);
    JULIA_OPENCL_FUNCTIONS(JULIA_OPENCL_FIND)
#undef JULIA_OPENCL_FIND
  }
};

}  // namespace

const OpenClFunctions* openClFunctions(std::string& refusal) {
  static const Loaded loaded;
  if (loaded.refusal.empty()) return &loaded.functions;
  refusal = loaded.refusal;
  return nullptr;
}

}  // namespace julia::device
