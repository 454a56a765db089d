// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/device_choice.h"

#include "maps/device_cache.h"

#include "vdbtools/base/text.h"
#include "vdbtools/recipe/option_value.h"

#include "julia/device/device.h"

#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace vdbtools {
namespace {

using Devices = std::vector<std::shared_ptr<const julia::Device>>;

/// All devices in one line, each with the reason why it is not used.
std::string listed(const Devices& devices) {
  std::string text;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const julia::DeviceInfo& info = devices[i]->info();
    text += (i == 0 ? "" : "; ") + std::to_string(i) + " is " + info.name +
            (info.refusal.empty() ? "" : ", which is not used: " + info.refusal);
  }
  return text;
}

/// The first device that can be used. @param gpu  whether it must be a graphics processor
std::optional<std::size_t> firstUsable(const Devices& devices, bool gpu) {
  for (std::size_t i = 0; i < devices.size(); ++i)
    if (const julia::DeviceInfo& info = devices[i]->info(); info.refusal.empty() && (info.isGpu || !gpu)) return i;
  return std::nullopt;
}

/// All graphics processors that can be used or, if there is none, all devices that can.
std::vector<std::size_t> allUsable(const Devices& devices) {
  const bool gpus = firstUsable(devices, true).has_value();
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < devices.size(); ++i)
    if (const julia::DeviceInfo& info = devices[i]->info(); info.refusal.empty() && (info.isGpu || !gpus))
      places.push_back(i);
  return places;
}

}  // namespace

std::string chooseDevice(const std::string& choice, const julia::DeviceNotice& notice) {
  constexpr std::string_view kNumbered = "opencl:";
  if (choice == "cpu") {
    julia::setCurrentDevice(nullptr);
    return {};
  }
  const bool isAuto = choice == "auto", isNumbered = choice.starts_with(kNumbered);
  if (!isAuto && !isNumbered && choice != "opencl")
    refuseChoice("device", choice, std::vector<std::string>{"cpu", "auto", "opencl"});
  const bool isAll = choice == "opencl:all";
  std::optional<int> number;
  if (isNumbered && !isAll) {
    number = wholeFromText<int>(choice.substr(kNumbered.size()));
    if (!number || *number < 0)
      throw std::invalid_argument(
          "the device is '" + choice +
          "'; after opencl: stands all, or the number of a device, as 'juliavdb devices' lists them");
  }
  std::string refusal;
  const Devices devices = julia::openDevices(notice, refusal, deviceCache());
  const auto use = [&](std::size_t place) {
    julia::setCurrentDevice(devices[place]);
    return "Evaluates on device " + std::to_string(place) + ", " + devices[place]->info().name + ".";
  };
  if (isAuto) {
    const std::optional<std::size_t> first = firstUsable(devices, true);
    if (first) return use(*first);
    julia::setCurrentDevice(nullptr);
    return "Evaluates on the processor: no graphics processor can be used ('juliavdb devices' says why).";
  }
  if (devices.empty()) throw DeviceError("no device of OpenCL can be used: " + refusal);
  if (isAll) {
    const std::vector<std::size_t> places = allUsable(devices);
    if (places.empty()) throw DeviceError("no device of OpenCL can be used: " + listed(devices));
    if (places.size() == 1) return use(places.front());
    Devices chosen;
    std::string names;
    for (const std::size_t place : places) {
      chosen.push_back(devices[place]);
      names += (names.empty() ? "" : "; ") + std::to_string(place) + ", " + devices[place]->info().name;
    }
    julia::setCurrentDevice(julia::joinedDevices(std::move(chosen)));
    return "Evaluates on the devices " + names + ".";
  }
  if (!isNumbered) {
    // Prefer a graphics processor.
    const std::optional<std::size_t> gpu = firstUsable(devices, true);
    const std::optional<std::size_t> first = gpu ? gpu : firstUsable(devices, false);
    if (first) return use(*first);
    throw DeviceError("no device of OpenCL can be used: " + listed(devices));
  }
  const auto place = static_cast<std::size_t>(*number);
  if (place >= devices.size())
    throw std::invalid_argument("the device is '" + choice + "', and there is no such device: " + listed(devices));
  const julia::DeviceInfo& info = devices[place]->info();
  if (!info.refusal.empty())
    throw DeviceError("the device '" + choice + "' cannot be used: " + info.name + ": " + info.refusal);
  return use(place);
}

}  // namespace vdbtools
