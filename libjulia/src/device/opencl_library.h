// SPDX-License-Identifier: Apache-2.0
/// @file opencl_library.h
/// OpenCL's loader, opened while the program runs: libOpenCL.so.1, or the file that the environment variable
/// JULIAVDB_OPENCL names.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <string>

namespace julia::device {

/// The functions of OpenCL 1.2 that are used, by their names without `cl`.
struct OpenClFunctions {
#define JULIA_OPENCL_FUNCTIONS(X)                                                                               \
  X(GetPlatformIDs)                                                                                             \
  X(GetPlatformInfo)                                                                                            \
  X(GetDeviceIDs)                                                                                               \
  X(GetDeviceInfo)                                                                                              \
  X(CreateContext)                                                                                              \
  X(ReleaseContext) X(CreateCommandQueue) X(ReleaseCommandQueue) X(CreateProgramWithSource) X(BuildProgram)     \
      X(GetProgramBuildInfo) X(ReleaseProgram) X(CreateKernel) X(ReleaseKernel) X(SetKernelArg) X(CreateBuffer) \
          X(ReleaseMemObject) X(EnqueueWriteBuffer) X(EnqueueReadBuffer) X(EnqueueNDRangeKernel) X(Finish)
#define JULIA_OPENCL_MEMBER(name) decltype(&::cl##name) name = nullptr;
  JULIA_OPENCL_FUNCTIONS(JULIA_OPENCL_MEMBER)
#undef JULIA_OPENCL_MEMBER
};

/// @return nullptr if there is no loader on this machine; @a refusal says so then
const OpenClFunctions* openClFunctions(std::string& refusal);

}  // namespace julia::device
