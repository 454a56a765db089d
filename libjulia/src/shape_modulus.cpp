// SPDX-License-Identifier: Apache-2.0
#include "julia/shape_modulus.h"

#include "ball_arithmetic.h"

#include <algorithm>
#include <array>
#include <vector>

namespace julia {

template <class Real>
ShapeModulus<Real>::ShapeModulus(std::shared_ptr<const ScalarField<Real>> exponent, const Rational& versor,
                                 DropAxis dropped)
    : mExponent(std::move(exponent)), mVersor(versor), mDropped(dropped) {}

template <class Real>
void ShapeModulus<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  switch (mDropped) {
    case DropAxis::I: return mExponent->sample(q.a, q.c, q.d, l);
    case DropAxis::J: return mExponent->sample(q.a, q.b, q.d, l);
    case DropAxis::K: return mExponent->sample(q.a, q.b, q.c, l);
  }
}

template <class Real>
void ShapeModulus<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  mVersor.versor(q, u);
}

template <class Real>
void ShapeModulus<Real>::logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const {
  // What is left of a ball without one component is a ball of three dimensions.
  std::vector<std::array<double, 3>> centres(balls.size());
  std::vector<double> radii(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Quaternion<double>& q = balls[i].centre;
    switch (mDropped) {
      case DropAxis::I: centres[i] = {q.a, q.c, q.d}; break;
      case DropAxis::J: centres[i] = {q.a, q.b, q.d}; break;
      case DropAxis::K: centres[i] = {q.a, q.b, q.c}; break;
    }
    radii[i] = balls[i].radius;
  }
  std::vector<ValueRange> ranges(balls.size());
  mExponent->ranges(centres, radii, ranges);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    l[i] = {ranges[i].low, ranges[i].high};
    if (balls[i].hollow > 0) l[i].low = std::max(l[i].low, mExponent->lowestBeyond(balls[i].hollow));
  }
}

template <class Real>
void ShapeModulus<Real>::images(std::span<const Ball> balls, std::span<const LogRange> l,
                                std::span<std::optional<Ball>> images) const {
  const int dropped = mDropped == DropAxis::I ? 1 : mDropped == DropAxis::J ? 2 : 3;
  imagesOf(mVersor, balls, l, images, dropped);
}

template class ShapeModulus<float>;
template class ShapeModulus<double>;

}  // namespace julia
