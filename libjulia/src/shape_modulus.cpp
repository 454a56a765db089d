// SPDX-License-Identifier: Apache-2.0
#include "julia/shape_modulus.h"

#include "ball_arithmetic.h"

#include "julia/elementary.h"
#include "julia/rational_versor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace julia {

template <class Real>
ShapeModulus<Real>::ShapeModulus(std::shared_ptr<const ScalarField<Real>> exponent,
                                 std::shared_ptr<const VersorField<Real>> versor, DropAxis dropped)
    : mExponent(std::move(exponent)), mVersor(std::move(versor)), mEmbedding{.dropped = dropped} {}

template <class Real>
ShapeModulus<Real>::ShapeModulus(std::shared_ptr<const ScalarField<Real>> exponent, const Rational& versor,
                                 DropAxis dropped)
    : ShapeModulus(std::move(exponent), std::make_shared<const RationalVersor<Real>>(versor), dropped) {}

template <class Real>
void ShapeModulus<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  const auto [x, y, z] = mEmbedding.point(Quaternion<std::span<const Real>>{q.a, q.b, q.c, q.d});
  mExponent->sample(x, y, z, l);
}

template <class Real>
void ShapeModulus<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  mVersor->versor(q, u);
}

template <class Real>
void ShapeModulus<Real>::logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const {
  // Dropping a component turns a ball of four dimensions into one of three.
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
  imagesOf<Real>(*mVersor, balls, l, images, &mEmbedding);
}

template <class Real>
typename Map<Real>::EscapeProof ShapeModulus<Real>::escapeProof(double wanted) const {
  // Finds the distance beyond which E is at least @a wanted.
  constexpr double kNearest = 0x1p-10, kFarthest = 0x1p20;
  double far = kNearest;
  while (far < kFarthest && !(mExponent->lowestBeyond(far) >= wanted)) far *= 2;
  if (!(far < kFarthest)) return {};
  double near = far / 2;
  for (int i = 0; i < 20; ++i) {
    const double middle = (near + far) / 2;
    (mExponent->lowestBeyond(middle) >= wanted ? far : near) = middle;
  }
  // Balls of the radius below turn versors by half a radian.
  constexpr double kTurning = 0.5;
  return {static_cast<Real>(elementary::log(far)) + 8 * std::numeric_limits<Real>::epsilon(),
          kTurning / mVersor->turning()};
}

template <class Real>
void ShapeModulus<Real>::escapeBounds(const QuaternionBatch<Real>& centres, Real radius,
                                      const typename Map<Real>::EscapeProof& proof, std::span<Real> bounds) const {
  const Quaternion<unsigned> numbers{0, 1, 2, 3};
  mVersor->logLeastParts(centres, radius, mEmbedding.slicePart(numbers), bounds);
  // |e^l v| is at least the required distance from the origin.
  constexpr Real kRounding = 32 * std::numeric_limits<Real>::epsilon();
  for (Real& bound : bounds) bound = (proof.least - bound) + kRounding * (1 + std::abs(proof.least - bound));
}

template class ShapeModulus<float>;
template class ShapeModulus<double>;

}  // namespace julia
