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
    find("clGetPlatformIDs", functions.GetPlatformIDs);
    find("clGetPlatformInfo", functions.GetPlatformInfo);
    find("clGetDeviceIDs", functions.GetDeviceIDs);
    find("clGetDeviceInfo", functions.GetDeviceInfo);
    find("clCreateContext", functions.CreateContext);
    find("clReleaseContext", functions.ReleaseContext);
    find("clCreateCommandQueue", functions.CreateCommandQueue);
    find("clReleaseCommandQueue", functions.ReleaseCommandQueue);
    find("clCreateProgramWithSource", functions.CreateProgramWithSource);
    find("clBuildProgram", functions.BuildProgram);
    find("clGetProgramBuildInfo", functions.GetProgramBuildInfo);
    find("clReleaseProgram", functions.ReleaseProgram);
    find("clCreateKernel", functions.CreateKernel);
    find("clReleaseKernel", functions.ReleaseKernel);
    find("clSetKernelArg", functions.SetKernelArg);
    find("clCreateBuffer", functions.CreateBuffer);
    find("clReleaseMemObject", functions.ReleaseMemObject);
    find("clEnqueueWriteBuffer", functions.EnqueueWriteBuffer);
    find("clEnqueueReadBuffer", functions.EnqueueReadBuffer);
    find("clEnqueueNDRangeKernel", functions.EnqueueNDRangeKernel);
    find("clFlush", functions.Flush);
    find("clGetEventInfo", functions.GetEventInfo);
    find("clWaitForEvents", functions.WaitForEvents);
    find("clReleaseEvent", functions.ReleaseEvent);
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
