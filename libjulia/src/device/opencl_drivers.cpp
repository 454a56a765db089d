// SPDX-License-Identifier: Apache-2.0
#include "device/opencl_drivers.h"

#include <CL/cl_icd.h>
#include <dlfcn.h>
#include <link.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <system_error>
#include <type_traits>

namespace julia::device {
namespace {

constexpr const char* kLoaderVariable = "JULIAVDB_OPENCL";
constexpr const char* kDriverVariable = "JULIAVDB_OPENCL_DRIVER";
constexpr const char* kLoader = "libOpenCL.so.1";
/// clGetExtensionFunctionAddress, which cl_khr_icd uses although OpenCL 1.2 deprecates it.
using AddressOf = void*(CL_API_CALL*)(const char*);
/// Vendors' drivers, as their packages and container toolkits name them.
constexpr const char* kVendorDrivers[] = {"libnvidia-opencl.so.1", "libamdocl64.so"};
/// Folders with these drivers in container images whose dynamic linker does not search there.
constexpr const char* kVendorFolders[] = {"/usr/local/nvidia/lib64/", "/opt/rocm/lib/", "/opt/rocm/opencl/lib/"};

std::string variable(const char* name) {
  const char* const text = std::getenv(name);
  return text ? text : "";
}

/// Why the last call of the linker failed.
std::string linkerReason() {
  const char* const text = dlerror();
  return text ? text : "the linker gives no reason";
}

/// The file of an open library.
std::string fileOf(void* library, const std::string& name) {
  const link_map* map = nullptr;
  return dlinfo(library, RTLD_DI_LINKMAP, &map) == 0 && map->l_name && *map->l_name ? map->l_name : name;
}

/// @param find  sets a function from its name
template <class Find>
OpenClFunctions functionsFrom(const Find& find) {
  OpenClFunctions functions;
#define JULIA_FIND(name) find("cl" #name, functions.name, [](const cl_icd_dispatch& table) { return table.cl##name; })
  JULIA_FIND(GetPlatformInfo);
  JULIA_FIND(GetDeviceIDs);
  JULIA_FIND(GetDeviceInfo);
  JULIA_FIND(CreateContext);
  JULIA_FIND(ReleaseContext);
  JULIA_FIND(CreateCommandQueue);
  JULIA_FIND(ReleaseCommandQueue);
  JULIA_FIND(CreateProgramWithSource);
  JULIA_FIND(CreateProgramWithBinary);
  JULIA_FIND(GetProgramInfo);
  JULIA_FIND(BuildProgram);
  JULIA_FIND(GetProgramBuildInfo);
  JULIA_FIND(ReleaseProgram);
  JULIA_FIND(CreateKernel);
  JULIA_FIND(ReleaseKernel);
  JULIA_FIND(SetKernelArg);
  JULIA_FIND(CreateBuffer);
  JULIA_FIND(ReleaseMemObject);
  JULIA_FIND(EnqueueWriteBuffer);
  JULIA_FIND(EnqueueReadBuffer);
  JULIA_FIND(EnqueueNDRangeKernel);
  JULIA_FIND(Flush);
  JULIA_FIND(GetEventInfo);
  JULIA_FIND(WaitForEvents);
  JULIA_FIND(ReleaseEvent);
#undef JULIA_FIND
  return functions;
}

/// @param list  clGetPlatformIDs, or the function that a driver has in its place
template <class List>
std::vector<cl_platform_id> platformsOf(const List& list) {
  cl_uint count = 0;
  if (list(0, nullptr, &count) != CL_SUCCESS) count = 0;
  std::vector<cl_platform_id> platforms(count);
  if (count != 0 && list(count, platforms.data(), nullptr) != CL_SUCCESS) platforms.clear();
  return platforms;
}

std::string counted(std::size_t platforms) {
  return platforms == 1 ? "1 platform" : std::to_string(platforms) + " platforms";
}

/// The search, in the order in which it is made.
struct Search : Drivers {
  /// @return whether there is a loader
  bool askLoader() {
    const std::string named = variable(kLoaderVariable), name = named.empty() ? kLoader : named;
    void* const library = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      places.push_back({"the loader " + name, linkerReason()});
      return false;
    }
    const std::string place = "the loader " + fileOf(library, name);
    std::string lacks;
    const auto symbol = [&](const char* function, auto& to, const auto&...) {
      void* const address = dlsym(library, function);
      if (!address && lacks.empty()) lacks = function;
      to = reinterpret_cast<std::remove_reference_t<decltype(to)>>(address);
    };
    decltype(&::clGetPlatformIDs) list = nullptr;
    symbol("clGetPlatformIDs", list);
    mLoader = functionsFrom(symbol);
    if (!lacks.empty()) {
      places.push_back({place, "it has no function " + lacks});
      return false;
    }
    const std::vector<cl_platform_id> found = platformsOf(list);
    for (const cl_platform_id id : found) platforms.push_back({id, &mLoader});
    places.push_back({place, counted(found.size())});
    return true;
  }

  /// Lists the files that tell the loader about drivers; the loader itself has read them.
  void listIcdFiles() {
    std::string folder = variable("OCL_ICD_VENDORS");
    if (folder.empty()) folder = variable("OPENCL_VENDOR_PATH");
    if (folder.empty()) folder = "/etc/OpenCL/vendors";
    std::set<std::filesystem::path> files;
    std::error_code error;
    for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
      if (it->path().extension() == ".icd") files.insert(it->path());
    if (std::filesystem::is_regular_file(folder, error)) files.insert(folder);
    if (files.empty()) places.push_back({folder, "no .icd file"});
    for (const std::filesystem::path& file : files) {
      std::string driver;
      std::ifstream text(file);
      std::getline(text, driver);
      void* const library = dlopen(driver.c_str(), RTLD_LAZY | RTLD_NOLOAD);
      std::string found = "it names " + driver + (library ? ", which is open" : ", which the loader could not use");
      // The linker knows why, such as a library that is too old.
      if (!library && !dlopen(driver.c_str(), RTLD_LAZY))
        if (const char* const reason = dlerror()) found += std::string(": ") + reason;
      places.push_back({file.string(), found});
      if (library) dlclose(library);
    }
  }

  /// Opens a driver that the loader does not know. @param name  a file, or a name for the linker @return the reason if
  /// it cannot be used
  std::string openDriver(const std::string& name) {
    void* const library = dlopen(name.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (!library) return linkerReason();
    const auto address = reinterpret_cast<AddressOf>(dlsym(library, "clGetExtensionFunctionAddress"));
    const auto list = address ? reinterpret_cast<clIcdGetPlatformIDsKHR_fn>(address("clIcdGetPlatformIDsKHR"))
                              : clIcdGetPlatformIDsKHR_fn{};
    if (!list) return fileOf(library, name) + " is no driver of OpenCL";
    const std::vector<cl_platform_id> found = platformsOf(list);
    for (const cl_platform_id id : found) {
      const cl_icd_dispatch& table = **reinterpret_cast<const cl_icd_dispatch* const*>(id);
      mDrivers.push_back(std::make_unique<OpenClFunctions>(
          functionsFrom([&](const char*, auto& to, const auto& entry) { to = entry(table); })));
      platforms.push_back({id, mDrivers.back().get()});
    }
    places.push_back({fileOf(library, name), counted(found.size())});
    return {};
  }

  void lookForVendorDrivers() {
    for (const std::string name : kVendorDrivers) {
      // The loader has opened it, so its platforms are listed already.
      if (void* const library = dlopen(name.c_str(), RTLD_LAZY | RTLD_NOLOAD)) {
        places.push_back({fileOf(library, name), "the loader has opened it"});
        dlclose(library);
        continue;
      }
      std::string why = openDriver(name);
      for (const std::string folder : kVendorFolders) {
        std::error_code error;
        if (!why.empty() && std::filesystem::exists(folder + name, error)) why = openDriver(folder + name);
      }
      if (!why.empty()) places.push_back({name, why});
    }
  }

  Search() {
    if (const std::string named = variable(kDriverVariable); !named.empty()) {
      const std::string why = openDriver(named);
      if (!why.empty()) places.push_back({named, why});
      if (platforms.empty())
        refusal = std::string(kDriverVariable) + " is '" + named + "'; " +
                  (why.empty() ? "this driver has no platform" : why);
      return;
    }
    const bool hasLoader = askLoader();
    if (hasLoader) listIcdFiles();
    lookForVendorDrivers();
    if (!platforms.empty()) return;
    if (hasLoader)
      refusal = "OpenCL's loader found no platform, and no vendor's driver was found: no driver of OpenCL is installed";
    else
      refusal = places.front().place + " cannot be used (" + places.front().found +
                "), and no vendor's driver was found; on Debian, install ocl-icd-libopencl1, or set " +
                std::string(kLoaderVariable) + " to the loader's file or " + kDriverVariable + " to the driver's";
  }

 private:
  OpenClFunctions mLoader;
  std::vector<std::unique_ptr<const OpenClFunctions>> mDrivers;
};

}  // namespace

const Drivers& openClDrivers() {
  // Never destroyed: devices that live until the process ends refer to it.
  static const auto* const search = new Search;
  return *search;
}

}  // namespace julia::device
