// SPDX-License-Identifier: Apache-2.0
/// @file device.h
/// Devices of OpenCL that evaluate F with the bits of the processor.
///
/// The device compiles the text from which the processor's kernels are made (kernels/shared), without fused operations
/// and with correctly rounded divisions and square roots. Before it is used for a field, it evaluates some thousand
/// points of that field, and the processor does the same; if a bit differs, the processor evaluates the field. Points
/// that the kernels leave out, such as one that hits a root, are evaluated by the processor as well: a point's value
/// does not depend on its batch.
///
/// OpenCL's loader and drivers are opened when a device is asked for; a program that asks for none runs without them.
/// They are looked for once in a process: the loader, libOpenCL.so.1 or the file that the environment variable
/// JULIAVDB_OPENCL names; and drivers of vendors that the loader does not know. If JULIAVDB_OPENCL_DRIVER names the
/// file of a driver, it alone is used.
#pragma once

#include "julia/evaluator.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace julia {

/// What is known of a device.
struct DeviceInfo {
  std::string name;      ///< as OpenCL has it: the device, the platform and the driver's version
  bool isGpu = false;    ///< a graphics processor, and not the processor itself or another device
  bool doubles = false;  ///< whether it computes in 64 bits
  std::string refusal;   ///< why it is not used; empty if it is
};

/// A device in use. Threads may share it.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceInfo& info() const = 0;

  /// An evaluator that evaluates on the device what @a host evaluates, with the same bits, and leaves the rest to it:
  /// proofs, versors, orbit traps. If the device fails, @a host goes on alone, and @a notice is called once with a
  /// sentence that says so.
  /// @param reason  receives why the device cannot evaluate this field, if it cannot; @a host is returned then
  virtual std::unique_ptr<FieldEvaluator> evaluator(std::unique_ptr<FieldEvaluator> host,
                                                    std::string& reason) const = 0;

  /// Tells the notice that the device was opened with.
  virtual void notify(const std::string& sentence) const = 0;
};

/// Receives what happens to a device: one sentence. Threads may call it.
using DeviceNotice = std::function<void(const std::string&)>;

/// Opens all devices, in OpenCL's order: platform by platform. Each one's arithmetic is tried, and those whose info has
/// a refusal cannot be used.
/// @param refusal  receives why there is none, if there is none
std::vector<std::shared_ptr<const Device>> openDevices(const DeviceNotice& notice, std::string& refusal);

/// Where drivers of OpenCL were looked for: a loader, a file or a folder, and what was found there, in words.
struct DriverPlace {
  std::string place, found;
};
/// All places, in the order of the search; it is made with the first call of this or of openDevices().
std::vector<DriverPlace> driverPlaces();

/// The device on which the process evaluates fields; nullptr, the default, for none. Like the instruction set
/// (instruction_set.h), it changes no result.
std::shared_ptr<const Device> currentDevice();
void setCurrentDevice(std::shared_ptr<const Device> device);

/// The evaluator on the current device, or @a host itself if there is none or if it cannot evaluate this field, which
/// its notice is told.
std::unique_ptr<FieldEvaluator> onCurrentDevice(std::unique_ptr<FieldEvaluator> host);

}  // namespace julia
