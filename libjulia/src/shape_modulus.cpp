// SPDX-License-Identifier: Apache-2.0
#include "julia/shape_modulus.h"

#include "ball_arithmetic.h"

#include <algorithm>

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
LogRange ShapeModulus<Real>::logModulusRange(const Ball& ball) const {
  const Quaternion<double>& q = ball.centre;
  // What is left of a ball without one component is a ball of three dimensions.
  const auto over = [&](double x, double y, double z) -> LogRange {
    const ValueRange range = mExponent->range({x, y, z}, ball.radius);
    return {ball.hollow > 0 ? std::max(range.low, mExponent->lowestBeyond(ball.hollow)) : range.low, range.high};
  };
  switch (mDropped) {
    case DropAxis::I: return over(q.a, q.c, q.d);
    case DropAxis::J: return over(q.a, q.b, q.d);
    case DropAxis::K: break;
  }
  return over(q.a, q.b, q.c);
}

template <class Real>
std::optional<Ball> ShapeModulus<Real>::image(const Ball& ball, const LogRange& l) const {
  std::optional<Ball> result;
  images({&ball, 1}, {&l, 1}, {&result, 1});
  return result;
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
