// SPDX-License-Identifier: Apache-2.0
/// @file versor_field.h
/// The seam for the direction of the shape modulus (shape_modulus.h): unit quaternions over the quaternions, of any
/// origin. [SK23] take the versor of a rational, and say that any map or vector field will do.
#pragma once

#include "julia/ball.h"
#include "julia/quaternion_batch.h"

#include <algorithm>
#include <any>
#include <limits>
#include <span>

namespace julia {

/// Evaluation is const and may run in many threads at once. A point's versor does not depend on the batch it came in.
template <class Real>
class VersorField {
 public:
  virtual ~VersorField() = default;

  /// u[i] = the versor at q[i]: of length 1 but for rounding, and finite also where it is not defined. @a u is resized.
  virtual void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const = 0;

  /// cones[i] holds what versor() computes at every q of ball i, rounding included. A field that can prove nothing
  /// inherits this function and the next two.
  virtual void cones(std::span<const Ball> /*balls*/, std::span<Cone> cones) const {
    std::fill(cones.begin(), cones.end(), Cone{});
  }
  /// l[i] = a lower bound of ln|v| over the ball of that radius about centre i, where v is what versor() computes
  /// without the component number @a dropped; -inf where nothing is known.
  virtual void logLeastParts(const QuaternionBatch<Real>& /*centres*/, Real /*radius*/, unsigned /*dropped*/,
                             std::span<Real> l) const {
    std::fill(l.begin(), l.end(), -std::numeric_limits<Real>::infinity());
  }
  /// By how many radians a versor turns over a unit of length, as a rule; infinity where logLeastParts() knows nothing.
  virtual double turning() const { return std::numeric_limits<double>::infinity(); }

  /// The field as a plain value, of a type of its own: a Rational, say. Empty if it has no description.
  virtual std::any describe() const { return {}; }
};

}  // namespace julia
