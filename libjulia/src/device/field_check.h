// SPDX-License-Identifier: Apache-2.0
/// @file field_check.h
/// Whether a device evaluates a field with the bits of the processor.
#pragma once

#include "julia/evaluator.h"

#include <span>

namespace julia::device {

/// What a device does for a field, as the functions of FieldEvaluator describe it. All throw DeviceFailure.
class DeviceCalls {
 public:
  virtual ~DeviceCalls() = default;

  virtual void evaluateThere(std::span<const Point> points, std::span<double> field,
                             std::span<int> iterations) const = 0;
  /// Whether it computes in 64 bits, which all other functions need.
  virtual bool searches() const = 0;
  virtual void findSignsThere(const SearchLattice& lattice, std::span<SignBlock> blocks) const = 0;
  virtual void findThere(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                         std::span<double> found) const = 0;
  virtual void findThere(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                         std::span<double> found) const = 0;
  virtual void followThere(const RayMarch& march, std::span<const MarchedRay> rays,
                           std::span<RayMeeting> met) const = 0;
};

/// Whether the device has the processor's bits at some thousand points of the field, and in searches about them.
/// @throw DeviceFailure
bool agrees(const DeviceCalls& device, const FieldEvaluator& host);

/// Whether the device meets the set where the processor does, along some hundred rays. @throw DeviceFailure
bool agreesOnRays(const DeviceCalls& device, const FieldEvaluator& host);

}  // namespace julia::device
