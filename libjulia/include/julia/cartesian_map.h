// SPDX-License-Identifier: Apache-2.0
/// @file cartesian_map.h
/// The seam for maps that are sums by nature, f(q) + c, and whose later steps may need what the orbit began with: a
/// Mandelbrot set's c is the point itself. A batch of points in, their iterates out. Their iterates stay below the
/// escape radius until they end, so that nothing needs the log-polar form of map.h.
///
/// The level of F is ln(escape): F < 0 says 'did not escape' (DESIGN.md 2.3).
#pragma once

#include "julia/ball.h"
#include "julia/quaternion_batch.h"

#include <optional>

namespace julia {

/// Evaluation is const and may run in many threads at once.
template <class Real>
class CartesianMap {
 public:
  virtual ~CartesianMap() = default;

  /// 4, or 3 for a map of R^3: [x y z 0] then stands for a point, and goes to such a one.
  virtual int dimension() const = 0;

  /// The first step: next[i] = the iterate after start[i]. An iterate with a component that is not finite has escaped,
  /// and so is what a map that is not defined at a point gives there.
  /// @param carried  empty on entry; what the later steps of each orbit are to know, or left empty
  virtual void begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
                     QuaternionBatch<Real>& next) const = 0;

  /// Each later step; @a carried has the same orbits as @a q, or is empty as begin() left it. @a next is resized.
  virtual void step(const QuaternionBatch<Real>& q, const QuaternionBatch<Real>& carried,
                    QuaternionBatch<Real>& next) const = 0;

  /// A ball that holds the iterates which step number @a number, the first being 1, makes of those in @a ball, as they
  /// are computed in Real, for all orbits that begin in @a start; but for points where the map is not defined. None if
  /// the map proves nothing.
  virtual std::optional<Ball> imageOf(const Ball& ball, const Ball& start, int number) const {
    (void)ball, (void)start, (void)number;
    return std::nullopt;
  }
  /// Whether it is defined at every point.
  virtual bool isDefinedEverywhere() const { return true; }

  /// What FieldEvaluator::versors() gives the versor of: the first iterate, unless the map has a better sign of where
  /// a point goes. @a direction is resized.
  virtual void direction(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& direction) const {
    QuaternionBatch<Real> carried;
    begin(start, carried, direction);
  }
};

}  // namespace julia
