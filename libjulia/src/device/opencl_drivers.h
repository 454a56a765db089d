// SPDX-License-Identifier: Apache-2.0
/// @file opencl_drivers.h
/// OpenCL's drivers, looked for and opened while the program runs: those of the loader, and those of vendors that no
/// .icd file names, as in container images into which a driver is mounted.
///
/// A driver is used without the loader by what the loader relies on itself (the extension cl_khr_icd): each platform
/// begins with the table of its functions. The environment is read and never changed, since other threads may read it.
#pragma once

#include "julia/device/device.h"

#include "device/opencl_library.h"

#include <string>
#include <vector>

namespace julia::device {

/// A platform, and the functions of its driver or of the loader.
struct Platform {
  cl_platform_id id = nullptr;
  const OpenClFunctions* functions = nullptr;
};

/// What the search found. It is made once for the process, with the first call; drivers stay open, for they do not
/// survive being unloaded.
struct Drivers {
  std::vector<Platform> platforms;  ///< the loader's first
  std::vector<DriverPlace> places;  ///< where drivers were looked for, in this order
  std::string refusal;              ///< why there is no platform, if there is none
};
const Drivers& openClDrivers();

}  // namespace julia::device
