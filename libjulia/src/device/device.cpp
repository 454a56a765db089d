// SPDX-License-Identifier: Apache-2.0
#include "julia/device/device.h"

#ifdef JULIA_OPENCL
#include "device/opencl_device.h"
#endif

#include <mutex>
#include <utility>

namespace julia {
namespace {

std::mutex& currentMutex() {
  static std::mutex mutex;
  return mutex;
}
std::shared_ptr<const Device>& currentPlace() {
  // Never destroyed: at exit, a driver may be gone before this would be.
  static auto* const current = new std::shared_ptr<const Device>;
  return *current;
}

}  // namespace

std::shared_ptr<const Device> currentDevice() {
  const std::lock_guard lock(currentMutex());
  return currentPlace();
}

void setCurrentDevice(std::shared_ptr<const Device> device) {
  const std::lock_guard lock(currentMutex());
  currentPlace() = std::move(device);
}

std::unique_ptr<FieldEvaluator> onCurrentDevice(std::unique_ptr<FieldEvaluator> host) {
  const std::shared_ptr<const Device> device = currentDevice();
  if (!device) return host;
  std::string reason;
  auto evaluator = device->evaluator(std::move(host), reason);
  if (!reason.empty()) device->notify("The processor evaluates the field, and not the device: " + reason + ".");
  return evaluator;
}

#ifdef JULIA_OPENCL

std::vector<std::shared_ptr<const Device>> openDevices(const DeviceNotice& notice, std::string& refusal,
                                                       const std::shared_ptr<const DeviceCache>& cache) {
  std::vector<std::shared_ptr<const Device>> devices;
  for (const auto& place : device::OpenClDevice::places(refusal))
    devices.push_back(std::make_shared<const device::OpenClDevice>(place, notice, cache));
  return devices;
}

std::vector<DriverPlace> driverPlaces() { return device::openClDrivers().places; }

#else

std::vector<std::shared_ptr<const Device>> openDevices(const DeviceNotice&, std::string& refusal,
                                                       const std::shared_ptr<const DeviceCache>&) {
  refusal = "this program was built without devices: " JULIA_NO_OPENCL;
  return {};
}

std::vector<DriverPlace> driverPlaces() { return {}; }

#endif

}  // namespace julia
