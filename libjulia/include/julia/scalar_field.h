// SPDX-License-Identifier: Apache-2.0
/// @file scalar_field.h
/// The seam for the exponent E: a scalar on R^3, read at a batch of points.
#pragma once

#include <span>

namespace julia {

template <class Real>
class ScalarField {
 public:
  virtual ~ScalarField() = default;

  /// out[i] = the field at (x[i], y[i], z[i]), finite. All spans have one size. May run in many threads at once.
  virtual void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
                      std::span<Real> out) const = 0;
};

}  // namespace julia
