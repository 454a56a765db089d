// SPDX-License-Identifier: Apache-2.0
/// @file ball_arithmetic.h
/// Building blocks of the bounds over balls. Bounds are computed in double by functions that give the same result on
/// every processor (elementary.h), and widened twice: by kSlack for their own rounding, and by the possible error of
/// the evaluator's Real.
#pragma once

#include "julia/ball.h"
#include "julia/embedding.h"
#include "julia/rational.h"

#include "kernels/elementary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace julia {

/// Relative slack of every bound. It covers some hundred roundings of doubles, and elementary functions that are
/// accurate to a few ulp.
inline constexpr double kSlack = 1e-13;

template <class Real>
inline constexpr double kEpsilonOf = static_cast<double>(std::numeric_limits<Real>::epsilon());

/// An upper bound of all results of Real that underflow, including sums of a few of them. Its square does not vanish.
template <class Real>
inline constexpr double kVanishing = static_cast<double>(std::numeric_limits<Real>::min()) < 1e-100 ? 1e-140 : 1e-36;

/// Images are not requested for a larger log-modulus: such a point has escaped. e to this is within floats.
inline constexpr double kMostLogModulus = 40;

inline double norm(const Quaternion<double>& q) { return std::sqrt(normSquared(q)); }

/// ln x; -inf for 0.
inline double logarithmOf(double x) {
  if (x >= std::numeric_limits<double>::max()) return std::numeric_limits<double>::infinity();
  if (x < std::numeric_limits<double>::min()) return -std::numeric_limits<double>::infinity();
  return kernels::logarithm(x);
}

/// The ball that contains the points of @a ball after rounding to Real, about a centre that is exact in Real.
template <class Real>
Ball roundedTo(const Ball& ball) {
  const Quaternion<double> centre = ball.centre.as<Real>().template as<double>();
  const double size = std::max({std::abs(centre.a), std::abs(centre.b), std::abs(centre.c), std::abs(centre.d)});
  // Half an ulp each for the centre and for the points, in four components.
  return {centre, (1 + kSlack) * (ball.radius + kEpsilonOf<Real> * 2 * (size + ball.radius) + kVanishing<Real>)};
}

/// A ball that contains e^l u for u in the cone and l in the range: the smallest one about a point s of the axis. With
/// moduli from m to M and an angle t < pi/2, the farthest points are those at the angle t, so s = min(M cos t, (m + M)
/// / (2 cos t)) is optimal. If nothing is known about u, it is the ball about 0.
/// @param cone       the versors u
/// @param l          the logarithms of the moduli
/// @param embedding  if given, Ball::hollow is computed for points without the dropped component: if the axis is at an
///                   angle v from that component's, the remaining part of u has the length sin v', with v' from v - t
///                   to v + t
template <class Real>
Ball imageOf(const Cone& cone, const LogRange& l, const Embedding* embedding) {
  const double high = kernels::exponential(l.high) * (1 + kSlack);
  const double low = l.low > l.high - 40 ? kernels::exponential(l.low) * (1 - kSlack) : 0;
  // The evaluator's e^l, the length of its u and their product are off by a few ulp, and underflow gives 0.
  const double rounding = 16 * kEpsilonOf<Real> * high + kVanishing<Real>;
  if (!(cone.quadrants < 1)) return {{}, high + rounding};
  double sine = 0, cosine = 1;
  kernels::sineCosine(cone.quadrants * (1 + kSlack), &sine, &cosine);
  const double along = std::min(high * cosine, (low + high) / (2 * cosine));
  const double across = along * sine, behind = along * cosine;
  const double longest = std::max(std::abs(low - behind), std::abs(high - behind));
  Ball ball{cone.axis * along, std::sqrt(longest * longest + across * across) + high * kSlack + rounding};
  if (embedding) {
    const double gone = embedding->slicePart(cone.axis);
    const double left = std::sqrt(std::max(normSquared(cone.axis) - gone * gone, 0.));
    ball.hollow = std::max(low * (left * cosine - std::abs(gone) * sine) - rounding, 0.);
  }
  return ball;
}

/// Images of balls under e^l times a versor. @param versor  has cones()  @param embedding  as in imageOf()
template <class Real, class Versor>
void imagesOf(const Versor& versor, std::span<const Ball> balls, std::span<const LogRange> l,
              std::span<std::optional<Ball>> images, const Embedding* embedding) {
  std::vector<Cone> cones(balls.size());
  versor.cones(balls, cones);
  for (std::size_t i = 0; i < balls.size(); ++i)
    images[i] = l[i].high <= kMostLogModulus ? std::optional(imageOf<Real>(cones[i], l[i], embedding)) : std::nullopt;
}

}  // namespace julia
