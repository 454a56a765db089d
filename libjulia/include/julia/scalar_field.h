// SPDX-License-Identifier: Apache-2.0
/// @file scalar_field.h
/// The interface of the exponent E of shape_modulus.h: a scalar on R^3, read at a batch of points.
#pragma once

#include "julia/bricks.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
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

  /// Sets out[i] to the field at (x[i], y[i], z[i]), which is finite. All spans have the same size. Many threads may
  /// call it at once.
  virtual void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
                      std::span<Real> out) const = 0;

  /// Sets out[i] to bounds of what sample() returns, rounding included, at every point of ball i. A field that can
  /// prove nothing inherits this function and lowestBeyond().
  virtual void ranges(std::span<const std::array<double, 3>> /*centres*/, std::span<const double> /*radii*/,
                      std::span<ValueRange> out) const {
    std::fill(out.begin(), out.end(), ValueRange{});
  }

  /// As ranges(), for one ball.
  ValueRange range(const std::array<double, 3>& centre, double radius) const {
    ValueRange result;
    ranges({&centre, 1}, {&radius, 1}, {&result, 1});
    return result;
  }

  /// A lower bound of what sample() returns wherever |x| >= distance.
  virtual double lowestBeyond(double /*distance*/) const { return -std::numeric_limits<double>::infinity(); }

  /// The values themselves, if the field is read from bricks.
  virtual std::optional<PlacedBricks> describe() const { return std::nullopt; }
};

}  // namespace julia
