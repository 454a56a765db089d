// SPDX-License-Identifier: Apache-2.0
/// @file map.h
/// The seam between a map and whoever iterates it: a batch of quaternions in, log-polar values out. The two halves are
/// asked for apart, because the last iterate needs no versor.
#pragma once

#include "julia/ball.h"
#include "julia/quaternion_batch.h"

#include <cstddef>
#include <optional>
#include <span>

namespace julia {

/// One step of a dynamical system on the quaternions. Evaluation is const and may run in many threads at once.
template <class Real>
class Map {
 public:
  virtual ~Map() = default;

  /// l[i] = ln|f(q[i])|, in [-inf, inf], never NaN. @pre l.size() == q.size()
  virtual void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const = 0;

  /// u[i] = f(q[i]) / |f(q[i])|, and 1 where f(q[i]) = 0. @a u is resized.
  virtual void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const = 0;

  /// The l on which the surface lies, given ln(escape): 0 for maps with super-attracting 0 and infinity, ln(escape) for
  /// those whose bounded orbits go anywhere (DESIGN.md 2.3).
  virtual Real surfaceLevel(Real logEscape) const = 0;

  /// Holds l as logModulus() computes it, rounding included, at each q of the ball.
  virtual LogRange logModulusRange(const Ball&) const { return {}; }

  /// Holds e^l u, as logModulus() and versor() compute them, for each q of the ball whose l lies in the range; empty if
  /// nothing is known.
  virtual std::optional<Ball> image(const Ball&, const LogRange&) const { return std::nullopt; }

  /// The same of many balls at once, for maps whose kernels like batches. All spans have one size.
  virtual void logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const {
    for (std::size_t i = 0; i < balls.size(); ++i) l[i] = logModulusRange(balls[i]);
  }
  virtual void images(std::span<const Ball> balls, std::span<const LogRange> l,
                      std::span<std::optional<Ball>> images) const {
    for (std::size_t i = 0; i < balls.size(); ++i) images[i] = image(balls[i], l[i]);
  }
};

}  // namespace julia
