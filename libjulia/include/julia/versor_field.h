// SPDX-License-Identifier: Apache-2.0
/// @file versor_field.h
/// The interface of the direction of the shape modulus (shape_modulus.h): a field of unit quaternions over the
/// quaternions, from any source. [SK23] take the versor of a rational, and say that any map or vector field will do.
#pragma once

#include "julia/ball.h"
#include "julia/quaternion_batch.h"

#include <algorithm>
#include <any>
#include <limits>
#include <span>

namespace julia {

/// Evaluation is const and may run in many threads at once. A point's versor does not depend on its batch.
template <class Real>
class VersorField {
 public:
  virtual ~VersorField() = default;

  /// Sets u[i] to the versor at q[i], whose length is 1 up to rounding and which is finite even where it is undefined.
  /// @a u is resized.
  virtual void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const = 0;

  /// Sets cones[i] to a cone that contains what versor() computes at every q of ball i, rounding included. A field that
  /// can prove nothing inherits this function and the next two.
  virtual void cones(std::span<const Ball> /*balls*/, std::span<Cone> cones) const {
    std::fill(cones.begin(), cones.end(), Cone{});
  }
  /// As Map::usefulRadius(), for cones().
  virtual double usefulRadius() const { return 0; }
  /// Sets l[i] to a lower bound of ln|v| over the ball of that radius about centre i, where v is what versor() computes
  /// without the component number @a dropped; -inf where nothing is known.
  virtual void logLeastParts(const QuaternionBatch<Real>& /*centres*/, Real /*radius*/, unsigned /*dropped*/,
                             std::span<Real> l) const {
    std::fill(l.begin(), l.end(), -std::numeric_limits<Real>::infinity());
  }
  /// The typical angle in radians by which a versor turns per unit of length; infinity if logLeastParts() knows
  /// nothing.
  virtual double turning() const { return std::numeric_limits<double>::infinity(); }

  /// The field as a plain value of its own type, e.g. a Rational; empty if it has no description.
  virtual std::any describe() const { return {}; }
};

}  // namespace julia
