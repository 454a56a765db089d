// SPDX-License-Identifier: Apache-2.0
/// @file cartesian_map.h
/// The interface of maps that are sums, f(q) + c, and whose later steps may need the point at which the orbit began: in
/// a Mandelbrot set, c is that point. A map takes a batch of points and returns their iterates. An iterate that is used
/// again lies below the escape radius, so these maps do not need the log-polar form of map.h.
///
/// The level of F is ln(escape): F < 0 means that the orbit did not escape (docs/design.md 2.3).
#pragma once

#include "julia/ball.h"
#include "julia/map_description.h"
#include "julia/quaternion_batch.h"

#include <optional>

namespace julia {

/// Evaluation is const and may run in many threads at once.
template <class Real>
class CartesianMap {
 public:
  virtual ~CartesianMap() = default;

  /// 4, or 3 for a map of R^3. A map of R^3 takes a point as [x y z 0] and returns another [x y z 0].
  virtual int dimension() const = 0;

  /// The first step: next[i] is the iterate after start[i]. An iterate with a component that is not finite has escaped;
  /// a map returns such a value where it is not defined.
  /// @param start    where the orbits begin
  /// @param carried  empty on entry; receives whatever the later steps of each orbit need, or stays empty
  /// @param next     resized
  virtual void begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
                     QuaternionBatch<Real>& next) const = 0;

  /// Each later step. @a carried holds one entry for each orbit of @a q, or is empty as begin() left it; @a next is
  /// resized.
  virtual void step(const QuaternionBatch<Real>& q, const QuaternionBatch<Real>& carried,
                    QuaternionBatch<Real>& next) const = 0;

  /// A ball that contains the iterates which step @a number (the first is 1) computes in Real from those in @a ball,
  /// for all orbits that begin in @a start. Points where the map is not defined are exempt. Empty if the map can prove
  /// nothing.
  virtual std::optional<Ball> imageOf(const Ball& ball, const Ball& start, int number) const {
    (void)ball, (void)start, (void)number;
    return std::nullopt;
  }
  /// Whether the map is defined at every point.
  virtual bool isDefinedEverywhere() const { return true; }

  /// Sets @a direction to the value whose versor FieldEvaluator::versors() returns: the first iterate, unless the map
  /// has a better measure of where a point goes. @a direction is resized.
  virtual void direction(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& direction) const {
    QuaternionBatch<Real> carried;
    begin(start, carried, direction);
  }

  /// The map as a plain value; empty if it has no description.
  virtual MapDescription describe() const { return {}; }
};

}  // namespace julia
