// SPDX-License-Identifier: Apache-2.0
// Bounds of a rational over balls. Over a ball of radius r whose centre is d > r away from t, the modulus of each
// factor q - t is between d - r and d + r, and its direction stays within w = asin(r/d).
#include "ball_arithmetic.h"
#include "batch_view.h"
#include "rational_factors.h"

#include <cstdint>
#include <type_traits>

namespace julia {
namespace {

using kernels::PowerMethod;
using kernels::RootFactor;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kHalfPi = 1.57079632679489661923;

/// The quantities at the centre of a ball from which the bounds of a factor are computed.
struct Distance {
  Quaternion<double> difference;  ///< q - t
  double imaginarySquared = 0, squared = 0;
};

template <class Real>
Distance distanceTo(const RootFactor<Real>& factor, const Quaternion<double>& q) {
  const Quaternion<double> d{q.a - static_cast<double>(factor.root[0]), q.b - static_cast<double>(factor.root[1]),
                             q.c - static_cast<double>(factor.root[2]), q.d - static_cast<double>(factor.root[3])};
  const double imaginary = d.b * d.b + d.c * d.c + d.d * d.d;
  return {d, imaginary, d.a * d.a + imaginary};
}

/// asin x <= x (1 + k x^2) with the k of the largest x, because (asin x / x - 1) / x^2 grows with x.
double arcSineBound(double x) { return x * (1 + (x <= 0.5 ? 0.1888 : 0.5708) * (x * x)); }

/// The factor by which u^p may turn faster than u. In u = cos t + n sin t the squared line element on the unit sphere
/// is dt^2 + sin^2 t dn^2, and that of u^p is p^2 dt^2 + sin^2 pt dn^2: the factor is the larger of |p| and |sin pt /
/// sin t|.
///  - For an integer p: never above |p|.
///  - For a real p: at most 1 / sin t. Within a ball t changes by at most w, so d sin t >= s cos w - |a| sin w, where a
///    and s are the real and the imaginary length of q - t, and d its length; negative if the ball reaches the real
///    axis.
///  - If t <= pi/2, also at most |p| pi/2, because sin t >= 2 t / pi there. This includes the positive half of the
///    axis.
/// On the negative half the power has a branch cut: kInfinity.
/// @param sine  sin w = r/d
template <class Real>
double turning(const RootFactor<Real>& factor, const Distance& at, double d, double sine) {
  const double p = std::abs(static_cast<double>(factor.power));
  if (factor.method != PowerMethod::Angle) return p;
  const double a = at.difference.a;
  // cos w >= 1 - sin^2 w. The usual case, s cos w >= |a| sin w + d/p, is tested in squares, without a square root.
  const double cosine = 1 - sine * sine, other = std::abs(a) * sine + d * (1 / p + kSlack);
  if (at.imaginarySquared * (cosine * cosine) >= other * other) return p;
  const double least = std::sqrt(at.imaginarySquared) * cosine - std::abs(a) * sine - d * kSlack;
  const double byDistance = least > 0 ? d / least : kInfinity;
  return std::max(p, a > d * sine * (1 + kSlack) ? std::min(byDistance, p * kHalfPi) : byDistance);
}

/// The sum of the angles by which the factors turn over a ball, in radians: the angle between two products of unit
/// quaternions is at most the sum of the angles between their factors. kInfinity as soon as the bound is useless.
template <class Real>
double turningOver(const std::vector<RootFactor<Real>>& factors, const Ball& ball) {
  double sum = 0;
  for (const RootFactor<Real>& factor : factors) {
    const Distance at = distanceTo(factor, ball.centre);
    if (!(at.squared > ball.radius * ball.radius)) return kInfinity;
    const double d = std::sqrt(at.squared), sine = ball.radius / d;
    sum += turning(factor, at, d, sine) * arcSineBound(sine);
    if (!(sum < kHalfPi)) return kInfinity;
  }
  return sum * (1 + kSlack);
}

/// How far rounding turns a versor. To first order it moves by eps (14 |p| + 16) for each factor and 5 eps for the last
/// normalisation (tests/support/rounding_bounds.h adds them up). This is doubled, because both the centre's and the
/// points' versors are rounded, and doubled again for higher orders.
template <class Real>
double versorRounding(const std::vector<RootFactor<Real>>& factors) {
  double sum = 5;
  for (const RootFactor<Real>& factor : factors) sum += 14 * std::abs(static_cast<double>(factor.power)) + 16;
  return 4 * kEpsilonOf<Real> * sum;
}

/// How rounding changes l, relative to the sum of |p ln|q - t|| and |C|: 2 eps for the logarithm and its argument, eps
/// for the power and the product, eps/2 for each sum. In addition there is kLogRounding eps for each |p|: the
/// logarithm's error where it is about 0 (tests/support/rounding_bounds.h).
template <class Real>
double logRounding(std::size_t count) {
  return kEpsilonOf<Real> * (4 + static_cast<double>(count));
}
constexpr double kLogRounding = 5;

/// Treats every root separately, for balls that come near one. The ends of p ln d move outward by their share of the
/// rounding, which keeps their order: p ln d is still largest at d + r for p > 0.
template <class Real>
LogRange logModulusNearRoots(const std::vector<RootFactor<Real>>& factors, double logScale, const Ball& ball) {
  const double relative = logRounding<Real>(factors.size()) + kSlack;
  double low = logScale - relative * std::abs(logScale), high = logScale + relative * std::abs(logScale);
  for (const RootFactor<Real>& factor : factors) {
    const double p = static_cast<double>(factor.power), d = std::sqrt(distanceTo(factor, ball.centre).squared);
    const double near = p * logarithmOf(d - ball.radius - kSlack * d), far = p * logarithmOf(d + ball.radius);
    const double least = std::min(near, far), most = std::max(near, far);
    const double absolute = kLogRounding * kEpsilonOf<Real> * std::abs(p);
    low += least - relative * std::abs(least) - absolute;
    high += most + relative * std::abs(most) + absolute;
  }
  return {low, high};
}

/// How far l may be above and below its value at the centre, and how far rounding may change it.
struct Spread {
  double up = 0, down = 0, rounding = 0;
};

/// With x = r/d < 1/2, ln(1 + x) <= x - x^2/2 + x^3/3 and -ln(1 - x) <= x + e, e = x^2 / (2 (1 - x)). Besides the sums
/// over the roots there is another bound: the gradient at the centre and the largest second derivative, which is 1/d^2
/// for a logarithm and integrates to the same e. Roots that pull in opposite directions cancel in it. kInfinity if an x
/// is larger.
template <class Real>
Spread spreadOver(const std::vector<RootFactor<Real>>& factors, double logScale, const Ball& ball) {
  Quaternion<double> gradient;
  double curved = 0, logs = std::abs(logScale), powers = 0;
  Spread sum;
  for (const RootFactor<Real>& factor : factors) {
    const double p = static_cast<double>(factor.power), size = std::abs(p);
    const Distance at = distanceTo(factor, ball.centre);
    if (!(at.squared > 4 * ball.radius * ball.radius)) return {kInfinity, kInfinity, 0};
    const double inverse = 1 / at.squared;
    const double square = ball.radius * ball.radius * inverse, x = std::sqrt(square);
    const double second = square / (2 * (1 - x));
    const double outward = size * (x - square * (0.5 - x / 3)), inward = size * (x + second);
    sum.up += p > 0 ? outward : inward;
    sum.down += p > 0 ? inward : outward;
    gradient = gradient + at.difference * (p * inverse);
    curved += size * second;
    // |ln d| up to a factor of 2 from the exponent of d^2, and another factor of 2 over the ball.
    const int exponent = static_cast<int>(kernels::bitsOf(at.squared) >> 52) - 1023;
    logs += size * 0.7 * (std::abs(0.5 * exponent) + 1.5);
    powers += size;
  }
  const double smooth = ball.radius * norm(gradient) + curved;
  return {std::min(sum.up, smooth), std::min(sum.down, smooth),
          logRounding<Real>(factors.size()) * logs + kLogRounding * kEpsilonOf<Real> * powers};
}

}  // namespace

template <class Real>
void RationalEvaluator<Real>::logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const {
  const auto& factors = mFactors->roots;
  const double logScale = static_cast<double>(mFactors->logScale);
  if (!(logRounding<Real>(factors.size()) < 0.1)) return std::fill(l.begin(), l.end(), LogRange{});
  QuaternionBatch<Real> centres;
  centres.resize(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) centres.set(i, balls[i].centre.as<Real>());
  std::vector<Real> values(balls.size());
  logModulus(centres, values);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Ball ball = roundedTo<Real>(balls[i]);
    const Spread spread = spreadOver(factors, logScale, ball);
    const double value = static_cast<double>(values[i]);
    if (spread.up < kInfinity && std::isfinite(value)) {
      // The centre's value is rounded, too.
      const double slack = 2 * spread.rounding + kSlack * (spread.up + spread.down + std::abs(value));
      l[i] = {value - spread.down - slack, value + spread.up + slack};
    } else {
      l[i] = logModulusNearRoots(factors, logScale, ball);
      // Coincident roots have opposite infinities.
      if (std::isnan(l[i].low) || std::isnan(l[i].high)) l[i] = {};
    }
  }
}

template <class Real>
void RationalEvaluator<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  if constexpr (std::is_same_v<Real, float>) {
    if (mWide) {
      mWide->cones(balls, cones);
      for (Cone& cone : cones) cone.quadrants += 2 * kEpsilonOf<float>;
      return;
    }
  }
  constexpr Cone kUnknown;
  std::fill(cones.begin(), cones.end(), kUnknown);
  const double rounding = versorRounding(mFactors->roots);
  if (!(rounding < 0.1)) return;
  QuaternionBatch<Real> centres, axes;
  centres.resize(balls.size());
  std::vector<std::uint32_t> known;
  known.reserve(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Ball ball = roundedTo<Real>(balls[i]);
    const double quadrants = (turningOver(mFactors->roots, ball) + rounding) * (1 / kHalfPi);
    if (!(quadrants < 1)) continue;
    cones[i].quadrants = quadrants;
    centres.set(known.size(), ball.centre.as<Real>());
    known.push_back(static_cast<std::uint32_t>(i));
  }
  centres.resize(known.size());
  versor(centres, axes);
  for (std::size_t i = 0; i < known.size(); ++i) cones[known[i]].axis = axes.get(i).template as<double>();
}

template <class Real>
void RationalEvaluator<Real>::logLeastParts(const QuaternionBatch<Real>& centres, Real radius, unsigned dropped,
                                            std::span<Real> l) const {
  const auto& factors = mFactors->roots;
  const double rounding = versorRounding(factors);
  if (mWide || !(rounding < 0.1)) return std::fill(l.begin(), l.end(), -std::numeric_limits<Real>::infinity());
  QuaternionBatch<Real> axes;
  versor(centres, axes);
  kernels::kernels<Real>().logLeastPart(factors.data(), factors.size(), radius, static_cast<Real>(rounding), dropped,
                                        view(centres), view(axes), l.data(), l.size());
}

template <class Real>
double RationalEvaluator<Real>::powers() const {
  double sum = 0;
  for (const RootFactor<Real>& factor : mFactors->roots) sum += std::abs(static_cast<double>(factor.power));
  return sum;
}

template void RationalEvaluator<float>::logLeastParts(const QuaternionBatch<float>&, float, unsigned,
                                                      std::span<float>) const;
template void RationalEvaluator<double>::logLeastParts(const QuaternionBatch<double>&, double, unsigned,
                                                       std::span<double>) const;
template double RationalEvaluator<float>::powers() const;
template double RationalEvaluator<double>::powers() const;
template void RationalEvaluator<float>::logModulusRanges(std::span<const Ball>, std::span<LogRange>) const;
template void RationalEvaluator<double>::logModulusRanges(std::span<const Ball>, std::span<LogRange>) const;
template void RationalEvaluator<float>::cones(std::span<const Ball>, std::span<Cone>) const;
template void RationalEvaluator<double>::cones(std::span<const Ball>, std::span<Cone>) const;

}  // namespace julia
