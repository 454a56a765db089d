// SPDX-License-Identifier: Apache-2.0
/// @file scalar_field.h
/// The seam for the exponent E: a scalar on R^3, read at a batch of points.
#pragma once

#include <algorithm>
#include <array>
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

  /// out[i] holds what sample() gives, rounding included, at each point of ball i. A field that knows nothing leaves
  /// this and lowestBeyond() as they are.
  virtual void ranges(std::span<const std::array<double, 3>> /*centres*/, std::span<const double> /*radii*/,
                      std::span<ValueRange> out) const {
    std::fill(out.begin(), out.end(), ValueRange{});
  }

  /// The same of one ball.
  ValueRange range(const std::array<double, 3>& centre, double radius) const {
    ValueRange result;
    ranges({&centre, 1}, {&radius, 1}, {&result, 1});
    return result;
  }

  /// Bounds from below what sample() gives wherever |x| >= distance.
  virtual double lowestBeyond(double /*distance*/) const { return -std::numeric_limits<double>::infinity(); }
};

}  // namespace julia
