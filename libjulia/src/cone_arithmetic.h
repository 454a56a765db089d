// SPDX-License-Identifier: Apache-2.0
/// @file cone_arithmetic.h
/// Bounds of the directions of quaternions over balls.
#pragma once

#include "ball_arithmetic.h"
#include "versor_arithmetic.h"

#include "julia/elementary.h"
#include "julia/embedding.h"
#include "julia/scalar_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace julia {

inline constexpr double kQuadrant = 1.57079632679489661923;  ///< pi/2

template <class Real>
std::vector<Ball> roundedTo(std::span<const Ball> balls) {
  std::vector<Ball> rounded(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) rounded[i] = roundedTo<Real>(balls[i]);
  return rounded;
}

/// Balls, without the component at which a scalar field is not read.
class BallsInSpace {
 public:
  BallsInSpace(std::span<const Ball> balls, const Embedding& embedding) {
    for (const Ball& ball : balls) {
      mCentres.push_back(embedding.point(ball.centre));
      mRadii.push_back(ball.radius);
    }
  }

  /// The ranges of a field over each ball.
  template <class Real>
  void rangesOf(const ScalarField<Real>& field, std::span<ValueRange> ranges) const {
    field.ranges(mCentres, mRadii, ranges);
  }

 private:
  std::vector<std::array<double, 3>> mCentres;
  std::vector<double> mRadii;
};

/// An upper bound of asin x; infinity from 1 on.
inline double arcSine(double x) {
  if (!(x < 1)) return std::numeric_limits<double>::infinity();
  return elementary::asin(x) * (1 + kSlack);
}

/// A ball that contains the versors of a cone; about 0 if nothing is known about them.
inline Ball chordBall(const Cone& cone) {
  if (!(cone.quadrants < 1)) return {{}, 1 + kSlack};
  return {cone.axis, std::min(cone.quadrants * kQuadrant, 2.) * (1 + kSlack)};
}

/// A cone that contains the directions of the quaternions in a ball; the full cone if the ball contains 0.
/// @param rounding  by how much rounding changes the direction and the length of a versor
inline Cone coneOf(const Ball& ball, double rounding) {
  const double quadrants = (arcSine((ball.radius + rounding) / norm(ball.centre)) + rounding) / kQuadrant;
  if (!(quadrants < 1)) return {};
  return {directionOf(ball.centre), quadrants + kSlack};
}

}  // namespace julia
