// SPDX-License-Identifier: Apache-2.0
/// @file device_choice.h
/// Chooses where the process evaluates maps, as --device does.
#pragma once

#include "julia/device/device.h"

#include <stdexcept>
#include <string>

namespace vdbtools {

/// No device can be used. The message gives the reason for each of them.
class DeviceError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Sets the device of the process: "cpu" for none, "opencl" for the first one that can be used, a graphics processor
/// before any other, "opencl:N" for number N of julia::openDevices(), "opencl:all" for all graphics processors that can
/// be used together, or else for all devices that can, and "auto" for the first graphics processor that can be used, or
/// none.
/// @param notice  called later if something happens to the device
/// @return a sentence about where maps are evaluated; empty for "cpu"
/// @throw std::invalid_argument  no such choice, or no such number
/// @throw DeviceError            no device can be used
std::string chooseDevice(const std::string& choice, const julia::DeviceNotice& notice);

}  // namespace vdbtools
