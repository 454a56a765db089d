// SPDX-License-Identifier: Apache-2.0
/// @file map.h
/// The seam between a map and whoever iterates it: a batch of quaternions in, log-polar values out. The two halves are
/// asked for apart, because the last iterate needs no versor.
#pragma once

#include "julia/quaternion_batch.h"

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
};

}  // namespace julia
