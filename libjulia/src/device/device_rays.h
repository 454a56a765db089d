// SPDX-License-Identifier: Apache-2.0
/// @file device_rays.h
/// Rays that a device follows.
#pragma once

#include "device/opencl_device.h"

#include "julia/ray_march.h"

#include "object_pool.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace julia::device {

/// For use by any number of threads.
class DeviceRays {
 public:
  /// Sets the arguments of a kernel that are the field's own.
  using SetField = std::function<void(const OpenClDevice::Lane&)>;

  DeviceRays(const OpenClDevice& device, std::shared_ptr<const OpenClDevice::Program> program, SetField setField);
  ~DeviceRays();

  /// As FieldEvaluator::followRays(). @throw DeviceFailure
  void follow(const RayMarch& march, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const;

 private:
  struct Work;

  /// Follows rays up to the number of samples that a kernel evaluates for each. @return the numbers of those that go
  /// on, whose next samples are in @a met
  std::vector<std::size_t> begin(const RayMarch& march, std::span<const MarchedRay> rays,
                                 std::span<RayMeeting> met) const;
  void followPiece(Work& work, std::span<const MarchedRay> rays, std::span<RayMeeting> met, std::size_t first,
                   std::vector<std::size_t>& goingOn) const;

  const OpenClDevice& mDevice;
  mutable ObjectPool<Work> mWork;
};

}  // namespace julia::device
