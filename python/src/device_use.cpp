// SPDX-License-Identifier: Apache-2.0
#include "device_use.h"

#include "patient_lock.h"

#include "vdbtools/maps/device_choice.h"

#include "julia/device/device.h"

#include <pybind11/pybind11.h>

#include <mutex>
#include <utility>

namespace py = pybind11;

namespace {

/// Guards the device of the process.
std::timed_mutex theDeviceMutex;

void warn(const std::string& sentence) {
  const py::gil_scoped_acquire held;
  PyErr_WarnEx(PyExc_RuntimeWarning, sentence.c_str(), 1);
  PyErr_Clear();  // a warning that is configured as an error must not stop anything in another thread
}

/// Restores the device of the process at the end of its scope.
class DeviceKeeper {
 public:
  DeviceKeeper() : mDevice(julia::currentDevice()) {}
  DeviceKeeper(const DeviceKeeper&) = delete;
  DeviceKeeper& operator=(const DeviceKeeper&) = delete;
  ~DeviceKeeper() { julia::setCurrentDevice(std::move(mDevice)); }

 private:
  std::shared_ptr<const julia::Device> mDevice;
};

}  // namespace

std::string useDevice(const std::string& choice) {
  const py::gil_scoped_release free;
  const std::scoped_lock lock(theDeviceMutex);
  return vdbtools::chooseDevice(choice, warn);
}

std::unique_ptr<julia::FieldEvaluator> evaluatorOn(const vdbtools::Scene& scene, const std::string& choice) {
  // A scene that another thread makes at the same time may use this device; its results have the same bits.
  const std::scoped_lock lock(theDeviceMutex);
  const DeviceKeeper keeper;
  vdbtools::chooseDevice(choice, warn);
  return scene.field.map->evaluator(scene.field.arithmetic, scene.field.orbit);
}

void onDevice(const std::string& choice, const vdbtools::Monitor& monitor, const std::function<void()>& work) {
  const auto lock = lockPatiently(theDeviceMutex, monitor);
  const DeviceKeeper keeper;
  vdbtools::chooseDevice(choice, warn);
  work();
}
