// SPDX-License-Identifier: Apache-2.0
/// @file scalar_field.h
/// The seam for the exponent E: a scalar on R^3, read at a batch of points.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>

namespace julia {

struct ValueRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

template <class Real>
class ScalarField {
 public:
  virtual ~ScalarField() = default;

  /// out[i] = the field at (x[i], y[i], z[i]), finite. All spans have one size. May run in many threads at once.
  virtual void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
                      std::span<Real> out) const = 0;

  /// Holds what sample() gives, rounding included, at each point of a ball. Whoever knows nothing says so.
  virtual ValueRange range(const std::array<double, 3>& /*centre*/, double /*radius*/) const { return {}; }

  /// The same of many balls at once.
  virtual void ranges(std::span<const std::array<double, 3>> centres, std::span<const double> radii,
                      std::span<ValueRange> out) const {
    for (std::size_t i = 0; i < centres.size(); ++i) out[i] = range(centres[i], radii[i]);
  }

  /// Bounds from below what sample() gives wherever |x| >= distance.
  virtual double lowestBeyond(double /*distance*/) const { return -std::numeric_limits<double>::infinity(); }
};

}  // namespace julia
