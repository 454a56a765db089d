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
    : mExponent(std::move(exponent)), mVersor(versor), mEmbedding{.dropped = dropped} {}

template <class Real>
void ShapeModulus<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  const auto [x, y, z] = mEmbedding.point(Quaternion<std::span<const Real>>{q.a, q.b, q.c, q.d});
  mExponent->sample(x, y, z, l);
}

template <class Real>
void ShapeModulus<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  mVersor.versor(q, u);
}

template <class Real>
void ShapeModulus<Real>::logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const {
  // Without one component, a ball of four dimensions becomes one of three.
  std::vector<std::array<double, 3>> centres(balls.size());
  std::vector<double> radii(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    centres[i] = mEmbedding.point(balls[i].centre);
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
  imagesOf(mVersor, balls, l, images, &mEmbedding);
}

template class ShapeModulus<float>;
template class ShapeModulus<double>;

}  // namespace julia
