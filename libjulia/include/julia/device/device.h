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
/// OpenCL's loader and drivers are opened when a device is requested; other programs run without them.
/// They are looked for once in a process: the loader, libOpenCL.so.1 or the file that the environment variable
/// JULIAVDB_OPENCL names; and drivers of vendors that the loader does not know. If JULIAVDB_OPENCL_DRIVER names the
/// file of a driver, it alone is used.
#pragma once

#include "julia/evaluator.h"

#include <cstddef>
#include <cstdint>
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

/// What a device has done so far, for all fields together.
struct DeviceUse {
  std::uint64_t calls = 0;       ///< how often the host waited for results
  std::uint64_t kernels = 0;     ///< how many kernels were started; those of one call follow each other without a wait
  std::uint64_t points = 0;      ///< at which F was evaluated, other than in searches and along rays
  std::uint64_t edges = 0;       ///< that were searched
  std::uint64_t rays = 0;        ///< that were followed
  std::uint64_t mostPoints = 0;  ///< of a call
  std::uint64_t mostEdges = 0;   ///< of a call
  std::uint64_t mostRays = 0;    ///< of a call
  std::uint64_t bytesTo = 0;     ///< that were copied to the device, other than those of fields
  std::uint64_t bytesOfFields = 0;  ///< of the fields' own numbers, which are copied once: roots, waves, bricks
  std::uint64_t bytesFrom = 0;      ///< that were copied from it
  double waited = 0;                ///< seconds that threads waited for results, added up
};

/// A device in use. Threads may share it.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceInfo& info() const = 0;
  virtual DeviceUse use() const = 0;

  /// An evaluator that evaluates on the device what @a host evaluates, with the same bits, and leaves the rest to it:
  /// proofs, versors, orbit traps. If the device fails, @a host evaluates everything from then on, and notify() is
  /// called once with a sentence about it.
  /// @param reason  receives why the device cannot evaluate this field, if it cannot; @a host is returned then
  virtual std::unique_ptr<FieldEvaluator> evaluator(std::unique_ptr<FieldEvaluator> host,
                                                    std::string& reason) const = 0;

  /// Whether evaluator() made this, and its device has not failed.
  virtual bool evaluates(const FieldEvaluator& evaluator) const = 0;

  /// Calls the DeviceNotice with which the device was opened.
  virtual void notify(const std::string& sentence) const = 0;
};

/// Called with one sentence for the user whenever something happens to a device, such as a failure. Several threads may
/// call it at once.
using DeviceNotice = std::function<void(const std::string&)>;

/// Keeps what devices compile, and which of them passed the test of its arithmetic, for later processes. Several
/// threads may call it at once.
class DeviceCache {
 public:
  virtual ~DeviceCache() = default;
  /// What was kept under a key, which tells devices, drivers, versions and texts apart; empty if there is nothing.
  virtual std::string find(const std::string& key) const = 0;
  virtual void keep(const std::string& key, const std::string& data) const = 0;
};

/// Opens all devices in OpenCL's order, platform by platform, and tests the arithmetic of each. A device whose info has
/// a refusal cannot be used.
/// @param refusal  receives the reason if there is no device at all
/// @param cache    may be null; with it, a test that was passed is not repeated
std::vector<std::shared_ptr<const Device>> openDevices(const DeviceNotice& notice, std::string& refusal,
                                                       const std::shared_ptr<const DeviceCache>& cache = nullptr);

/// Several devices as one: they share the points, the nodes and the edges of each call. A device that fails leaves its
/// part to the processor, and the others share the later calls. A field that one of them cannot evaluate, the others
/// do.
/// @param devices  one at least, none of them refused
std::shared_ptr<const Device> joinedDevices(std::vector<std::shared_ptr<const Device>> devices);

/// A place where drivers of OpenCL were looked for (a loader, a file or a folder), and what was found there, in words.
struct DriverPlace {
  std::string place, found;
};
/// All places, in the order of the search. The first call of this function or of openDevices() makes the search.
std::vector<DriverPlace> driverPlaces();

/// The device on which the process evaluates fields; nullptr, the default, for none. Like the instruction set
/// (instruction_set.h), it changes no result.
std::shared_ptr<const Device> currentDevice();
void setCurrentDevice(std::shared_ptr<const Device> device);

/// The evaluator on the current device. Returns @a host itself if there is no device, or if the device cannot evaluate
/// this field; in the second case, the device's notice is called with the reason.
std::unique_ptr<FieldEvaluator> onCurrentDevice(std::unique_ptr<FieldEvaluator> host);

}  // namespace julia
