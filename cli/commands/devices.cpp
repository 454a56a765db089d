// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"

#include "julia/device/device.h"

#include <nlohmann/json.hpp>

#include <iostream>

namespace cli {
namespace {

constexpr Usage kDevicesUsage = {
    "devices", "[--json]",
    "Lists the devices of OpenCL, with their numbers for --device, and tries the arithmetic of each: a device is used "
    "only if its results have the bits of the processor's. What is not used is listed with the reason, and then where "
    "drivers were looked for.",
    "  juliavdb devices\n"
    "  juliavdb devices --json\n"};

}  // namespace

int runDevices(const Arguments& arguments) {
  CommandLine line(kDevicesUsage, vdbtools::OptionTable());
  line.addOptions()("json", "the list for other programs");
  if (!line.parse(arguments)) return kDone;
  std::string refusal;
  const auto devices = julia::openDevices({}, refusal);
  if (line.has("json")) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& device : devices) {
      const julia::DeviceInfo& info = device->info();
      list.push_back({{"name", info.name},
                      {"gpu", info.isGpu},
                      {"doubles", info.doubles},
                      {"usable", info.refusal.empty()},
                      {"refusal", info.refusal}});
    }
    nlohmann::json drivers = nlohmann::json::array();
    for (const julia::DriverPlace& looked : julia::driverPlaces())
      drivers.push_back({{"place", looked.place}, {"found", looked.found}});
    std::cout << nlohmann::json{{"devices", list}, {"drivers", drivers}, {"refusal", refusal}}.dump(1) << '\n';
    return kDone;
  }
  if (devices.empty()) std::cout << "There is no device: " << refusal << ".\n";
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const julia::DeviceInfo& device = devices[i]->info();
    std::cout << "opencl:" << i << "  " << device.name << '\n' << "          ";
    if (device.refusal.empty())
      std::cout << (device.isGpu ? "a graphics processor" : "not a graphics processor") << ", "
                << (device.doubles ? "in 32 and 64 bits" : "in 32 bits only")
                << "; its arithmetic has the processor's bits\n";
    else
      std::cout << "not used: " << device.refusal << '\n';
  }
  const auto places = julia::driverPlaces();
  if (!places.empty()) std::cout << "Drivers were looked for in\n";
  for (const julia::DriverPlace& looked : places) std::cout << "  " << looked.place << ": " << looked.found << '\n';
  return kDone;
}

}  // namespace cli
