// SPDX-License-Identifier: Apache-2.0
#include "julia/quadratic_map.h"

#include "ball_arithmetic.h"
#include "batch_view.h"
#include "cartesian_balls.h"
#include "norms.h"

#include <cmath>
#include <limits>

namespace julia {

namespace {

template <class Real>
void squaresPlus(const kernels::Addend<Real>& c, const QuaternionBatch<Real>& q, QuaternionBatch<Real>& f) {
  f.resize(q.size());
  kernels::kernels<Real>().quadratic(c, view(q), view(f), q.size());
}

}  // namespace

template <class Real>
void QuadraticMap<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  QuaternionBatch<Real> f;
  squaresPlus(addend(mC), q, f);
  logNorms(f, l);
}

template <class Real>
void QuadraticMap<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  QuaternionBatch<Real> f;
  squaresPlus(addend(mC), q, f);
  versorsOf(f, u);
}

/// (q + d)^2 + c = q^2 + c + (q d + d q) + d^2. The evaluator's four products and sums per component have a total error
/// of 8 eps (|q|^2 + |c|).
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
  // The errors of the logarithm itself and of |f|.
  const auto rounding = [](double l) { return kEpsilonOf<Real> * (2 * std::abs(l) + 4) + kSlack; };
  return {low > -std::numeric_limits<double>::infinity() ? low - rounding(low) : low, high + rounding(high)};
}

template <class Real>
std::optional<Ball> QuadraticMap<Real>::imageOf(const Ball& ball, const LogRange& l) const {
  if (!(l.high <= kMostLogModulus)) return std::nullopt;
  Ball value = valueOver(ball);
  // The evaluator continues with e^l u, whose length has the error of l: eps (2 |l| + 4). |l| e^l <= 1/e for l < 0.
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

template <class Real>
void QuadraticMandelbrot<Real>::begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
                                      QuaternionBatch<Real>& next) const {
  carried = start;
  step(start, carried, next);
}

template <class Real>
void QuadraticMandelbrot<Real>::step(const QuaternionBatch<Real>& q, const QuaternionBatch<Real>& carried,
                                     QuaternionBatch<Real>& next) const {
  squaresPlus(addend(carried), q, next);
}

template <class Real>
std::optional<Ball> QuadraticMandelbrot<Real>::imageOf(const Ball& ball, const Ball& start, int) const {
  return sumOf<Real>(squareOf<Real>(ball), start);
}

template class QuadraticMandelbrot<float>;
template class QuadraticMandelbrot<double>;

double quadraticBound(const Quaternion<double>& c, int iterations, double escapeRadius) {
  const double shift = std::sqrt(normSquared(c));
  double radius = escapeRadius;
  for (int i = 0; i < iterations; ++i) {
    const double before = std::sqrt(radius + shift);
    // Beyond the fixed point the bound does not decrease further.
    if (before >= radius) break;
    radius = before;
  }
  return radius;
}

}  // namespace julia
