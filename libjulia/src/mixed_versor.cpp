// SPDX-License-Identifier: Apache-2.0
#include "julia/mixed_versor.h"

#include "cone_arithmetic.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace julia {

namespace {

template <class Real>
Quaternion<Real> mixed(const Quaternion<Real>& u, const Quaternion<Real>& v, Real m) {
  return {kernels::mixedPart(u.a, v.a, m), kernels::mixedPart(u.b, v.b, m), kernels::mixedPart(u.c, v.c, m),
          kernels::mixedPart(u.d, v.d, m)};
}

}  // namespace

template <class Real>
MixedVersor<Real>::MixedVersor(std::shared_ptr<const VersorField<Real>> under,
                               std::shared_ptr<const VersorField<Real>> over,
                               std::shared_ptr<const ScalarField<Real>> mix, DropAxis dropped)
    : mUnder(std::move(under)), mOver(std::move(over)), mMix(std::move(mix)), mEmbedding{.dropped = dropped} {}

template <class Real>
void MixedVersor<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  std::vector<Real> mix(q.size());
  const auto [x, y, z] = mEmbedding.point(Quaternion<std::span<const Real>>{q.a, q.b, q.c, q.d});
  mMix->sample(x, y, z, mix);
  if (std::all_of(mix.begin(), mix.end(), [](Real m) { return m <= 0; })) return mUnder->versor(q, u);
  if (std::all_of(mix.begin(), mix.end(), [](Real m) { return m >= 1; })) return mOver->versor(q, u);
  QuaternionBatch<Real> v;
  mUnder->versor(q, u);
  mOver->versor(q, v);
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Real m = mix[i];
    if (m <= 0) continue;
    u.set(i, m >= 1 ? v.get(i) : directionOf(mixed(u.get(i), v.get(i), m)));
  }
}

template <class Real>
void MixedVersor<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  const BallsInSpace space(roundedTo<Real>(balls), mEmbedding);
  std::vector<ValueRange> mixes(balls.size());
  space.rangesOf(*mMix, mixes);
  std::vector<Cone> over(balls.size());
  mUnder->cones(balls, cones);
  mOver->cones(balls, over);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const auto [low, high] = mixes[i];
    if (high <= 0) continue;
    if (low >= 1) {
      cones[i] = over[i];
      continue;
    }
    const double least = std::max(low, 0.), most = std::min(high, 1.), middle = (least + most) / 2;
    const Ball u = chordBall(cones[i]), v = chordBall(over[i]);
    // Mixes of the two centres lie on a segment. Mixes of other points of the balls are within across() of it.
    const double along = norm(v.centre - u.centre) * (most - least) / 2;
    const auto across = [&](double m) { return u.radius * (1 - m) + v.radius * m; };
    cones[i] = coneOf(
        {u.centre * (1 - middle) + v.centre * middle, (along + std::max(across(least), across(most))) * (1 + kSlack)},
        32 * kEpsilonOf<Real>);
  }
}

template class MixedVersor<float>;
template class MixedVersor<double>;

}  // namespace julia
