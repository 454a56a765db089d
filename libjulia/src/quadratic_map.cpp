// SPDX-License-Identifier: Apache-2.0
#include "julia/quadratic_map.h"

#include "ball_arithmetic.h"
#include "batch_view.h"
#include "careful.h"

#include <cmath>
#include <limits>

namespace julia {

namespace {

template <class Real>
QuaternionBatch<Real> squaresPlus(const Quaternion<Real>& c, const QuaternionBatch<Real>& q) {
  QuaternionBatch<Real> f;
  f.resize(q.size());
  const Real constant[4] = {c.a, c.b, c.c, c.d};
  kernels::kernels<Real>().quadratic(constant, view(q), view(f), q.size());
  return f;
}

template <class Real>
bool isNormal(const Quaternion<Real>& q) {
  const Real squared = normSquared(q);
  return squared >= kernels::Ieee<Real>::kTiny && squared <= std::numeric_limits<Real>::max();
}

}  // namespace

template <class Real>
void QuadraticMap<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  const QuaternionBatch<Real> f = squaresPlus(mC, q);
  kernels::kernels<Real>().logNorm(view(f), l.data(), f.size());
  for (std::size_t i = 0; i < f.size(); ++i)
    if (!isNormal(f.get(i))) l[i] = careful::logNorm(f.get(i));
}

template <class Real>
void QuadraticMap<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  const QuaternionBatch<Real> f = squaresPlus(mC, q);
  u = f;
  kernels::kernels<Real>().normalise(view(u), u.size());
  for (std::size_t i = 0; i < f.size(); ++i)
    if (!isNormal(f.get(i))) u.set(i, careful::versorOf(f.get(i)));
}

/// (q + d)^2 + c = q^2 + c + (q d + d q) + d^2. The evaluator's four products and sums a component are off by 8 eps
/// (|q|^2 + |c|) together.
template <class Real>
Ball QuadraticMap<Real>::valueOver(const Ball& ball) const {
  const Quaternion<double> c = mC.template as<double>();
  const double size = norm(ball.centre), most = size + ball.radius;
  return {ball.centre * ball.centre + c, (1 + kSlack) * (2 * size + ball.radius) * ball.radius +
                                             (8 * kEpsilonOf<Real> + kSlack) * (most * most + norm(c)) +
                                             kVanishing<Real>};
}

template <class Real>
LogRange QuadraticMap<Real>::rangeOver(const Ball& ball) const {
  const Ball value = valueOver(ball);
  const double size = norm(value.centre);
  const double low = logarithmOf(size - value.radius), high = logarithmOf(size + value.radius);
  // The logarithm's own error, and that of |f|.
  const auto rounding = [](double l) { return kEpsilonOf<Real> * (2 * std::abs(l) + 4) + kSlack; };
  return {low > -std::numeric_limits<double>::infinity() ? low - rounding(low) : low, high + rounding(high)};
}

template <class Real>
std::optional<Ball> QuadraticMap<Real>::imageOf(const Ball& ball, const LogRange& l) const {
  if (!(l.high <= kMostLogModulus)) return std::nullopt;
  Ball value = valueOver(ball);
  // The evaluator goes on with e^l u, whose length is off by what l is: eps (2 |l| + 4). |l| e^l <= 1/e for l < 0.
  const double most = kernels::exponential(l.high) * (1 + kSlack);
  value.radius += kEpsilonOf<Real> * (most * (2 * std::max(l.high, 0.) + 24) + 1);
  const double about0 = most * (1 + 32 * kEpsilonOf<Real>)+kVanishing<Real>;
  return value.radius < about0 ? value : Ball{{}, about0};
}

template <class Real>
void QuadraticMap<Real>::logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const {
  for (std::size_t i = 0; i < balls.size(); ++i) l[i] = rangeOver(balls[i]);
}

template <class Real>
void QuadraticMap<Real>::images(std::span<const Ball> balls, std::span<const LogRange> l,
                                std::span<std::optional<Ball>> images) const {
  for (std::size_t i = 0; i < balls.size(); ++i) images[i] = imageOf(balls[i], l[i]);
}

template class QuadraticMap<float>;
template class QuadraticMap<double>;

double quadraticBound(const Quaternion<double>& c, int iterations, double escapeRadius) {
  const double shift = std::sqrt(normSquared(c));
  double radius = escapeRadius;
  for (int i = 0; i < iterations; ++i) {
    const double before = std::sqrt(radius + shift);
    // Past the fixed point the bound falls no further.
    if (before >= radius) break;
    radius = before;
  }
  return radius;
}

}  // namespace julia
