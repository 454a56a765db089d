// SPDX-License-Identifier: Apache-2.0
#include "julia/mandelbulb.h"

#include "batch_view.h"
#include "cartesian_balls.h"
#include "number_text.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace julia {
namespace {

constexpr double kMostPower = 100;
// Above this, repeated squaring accumulates errors, and angles are as accurate.
constexpr double kMostByProducts = 64;

}  // namespace

int wholeTriplexPower(double power) {
  const bool byProducts = power >= 2 && power <= kMostByProducts && power == std::floor(power);
  return byProducts ? static_cast<int>(power) : 0;
}

template <class Real>
Mandelbulb<Real>::Mandelbulb(const MandelbulbOptions& options) : mOptions(options) {
  if (!(std::abs(options.power) <= kMostPower))
    throw std::invalid_argument("the triplex power is " + textOf(options.power) + "; it must be between -100 and 100");
  if (!options.constant) return;
  requireConstant(*options.constant);
  mConstant = Embedding{}.quaternion<Real>(*options.constant);
}

template <class Real>
void Mandelbulb<Real>::begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
                             QuaternionBatch<Real>& next) const {
  if (!mConstant) carried = start;
  step(start, carried, next);
}

template <class Real>
void Mandelbulb<Real>::step(const QuaternionBatch<Real>& p, const QuaternionBatch<Real>& carried,
                            QuaternionBatch<Real>& next) const {
  if (mConstant)
    power(p, *mConstant, next);
  else
    power(p, carried, next);
}

template <class Real>
void Mandelbulb<Real>::direction(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& direction) const {
  power(start, Quaternion<Real>{}, direction);
}

template <class Real>
std::optional<Ball> Mandelbulb<Real>::imageOf(const Ball& ball, const Ball& start, int) const {
  if (wholeTriplexPower(mOptions.power) == 0) return std::nullopt;
  const Ball power = triplexPowerOf<Real>(wholeTriplexPower(mOptions.power), mOptions.angle, ball);
  return sumOf<Real>(power, mConstant ? Ball{mConstant->template as<double>(), 0} : start);
}

template <class Real>
template <class Constant>
void Mandelbulb<Real>::power(const QuaternionBatch<Real>& p, const Constant& constant,
                             QuaternionBatch<Real>& next) const {
  const kernels::TriplexPower<Real> triplex{static_cast<Real>(mOptions.power),
                                            static_cast<std::uint32_t>(wholeTriplexPower(mOptions.power)),
                                            mOptions.angle == TriplexAngle::FromPole};
  next.resize(p.size());
  kernels::kernels<Real>().triplex(triplex, addend(constant), view(p), view(next), p.size());
}

template class Mandelbulb<float>;
template class Mandelbulb<double>;

double triplexBound(const MandelbulbOptions& options, int iterations, double escapeRadius) {
  if (!(options.power >= 2)) return escapeRadius;
  // Whether points this far out escape. Then all points farther out do, because the bound grows with |p| while it is
  // above 1.
  const auto escapes = [&](double radius) {
    double shift = radius;
    if (options.constant) {
      const Point& c = *options.constant;
      shift = elementary::hypot(c[0], c[1], c[2]);
    }
    double least = radius;
    for (int i = 0; i < iterations && least > 1 && least < escapeRadius; ++i)
      least = elementary::pow(least, options.power) - shift;
    return least >= escapeRadius;
  };
  double low = 1, high = escapeRadius;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (escapes(middle) ? high : low) = middle;
  }
  // Allows for rounding in float.
  return std::min(high * (1 + 1e-6), escapeRadius);
}

}  // namespace julia
