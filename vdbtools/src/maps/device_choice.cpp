// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/device_choice.h"

#include "vdbtools/base/number_text.h"
#include "vdbtools/recipe/option_value.h"

#include "julia/device/device.h"

#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace vdbtools {
namespace {

/// All devices in one line, each with why it is not used.
std::string listed(const std::vector<julia::DeviceInfo>& devices) {
  std::string text;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const julia::DeviceInfo& device = devices[i];
    text += (i == 0 ? "" : "; ") + std::to_string(i) + " is " + device.name +
            (device.refusal.empty() ? "" : ", which is not used: " + device.refusal);
  }
  return text;
}

/// The first device that can be used. @param gpu  whether it must be a graphics processor
std::optional<std::size_t> firstUsable(const std::vector<julia::DeviceInfo>& devices, bool gpu) {
  for (std::size_t i = 0; i < devices.size(); ++i)
    if (devices[i].refusal.empty() && (devices[i].isGpu || !gpu)) return i;
  return std::nullopt;
}

}  // namespace

std::string chooseDevice(const std::string& choice, const julia::DeviceNotice& notice) {
  const auto use = [&](std::size_t number) {
    try {
      julia::setCurrentDevice(julia::openDevice(number, notice));
    } catch (const std::runtime_error& error) {
      throw DeviceError(error.what());
    }
    return "Evaluates on device " + std::to_string(number) + ", " + julia::currentDevice()->info().name + ".";
  };
  constexpr std::string_view kNumbered = "opencl:";
  if (choice == "cpu") {
    julia::setCurrentDevice(nullptr);
    return {};
  }
  const bool isAuto = choice == "auto", isNumbered = choice.starts_with(kNumbered);
  if (!isAuto && !isNumbered && choice != "opencl")
    refuseChoice("device", choice, std::vector<std::string>{"cpu", "auto", "opencl"});
  std::optional<int> number;
  if (isNumbered) {
    number = wholeFromText<int>(choice.substr(kNumbered.size()));
    if (!number || *number < 0)
      throw std::invalid_argument("the device is '" + choice +
                                  "'; after opencl: stands the number of a device, as 'juliavdb devices' lists them");
  }
  std::string refusal;
  const std::vector<julia::DeviceInfo> devices = julia::listDevices(refusal);
  if (isAuto) {
    const std::optional<std::size_t> first = firstUsable(devices, true);
    if (first) return use(*first);
    julia::setCurrentDevice(nullptr);
    return "Evaluates on the processor: no graphics processor can be used ('juliavdb devices' says why).";
  }
  if (devices.empty()) throw DeviceError("no device of OpenCL can be used: " + refusal);
  if (!isNumbered) {
    // A graphics processor if there is one.
    const std::optional<std::size_t> gpu = firstUsable(devices, true);
    const std::optional<std::size_t> first = gpu ? gpu : firstUsable(devices, false);
    if (first) return use(*first);
    throw DeviceError("no device of OpenCL can be used: " + listed(devices));
  }
  const auto place = static_cast<std::size_t>(*number);
  if (place >= devices.size())
    throw std::invalid_argument("the device is '" + choice + "', and there is no such device: " + listed(devices));
  if (!devices[place].refusal.empty())
    throw DeviceError("the device '" + choice + "' cannot be used: " + devices[place].name + ": " +
                      devices[place].refusal);
  return use(place);
}

}  // namespace vdbtools
