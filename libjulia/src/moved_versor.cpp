// SPDX-License-Identifier: Apache-2.0
#include "julia/moved_versor.h"

#include "cone_arithmetic.h"
#include "number_text.h"

#include "julia/elementary.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace julia {
namespace {

bool isFinite(const Quaternion<double>& q) {
  return std::isfinite(q.a) && std::isfinite(q.b) && std::isfinite(q.c) && std::isfinite(q.d);
}

/// (@a q - t) / s, for every number type.
template <class Number>
Quaternion<Number> placedAt(const Quaternion<Number>& q, const Quaternion<double>& t, double s) {
  const Quaternion<Number> by = t.as<Number>();
  const Number scale = static_cast<Number>(s);
  return {kernels::movedBack(q.a, by.a, scale), kernels::movedBack(q.b, by.b, scale),
          kernels::movedBack(q.c, by.c, scale), kernels::movedBack(q.d, by.d, scale)};
}

}  // namespace

template <class Real>
MovedVersor<Real>::MovedVersor(std::shared_ptr<const VersorField<Real>> versor, double scale,
                               const Quaternion<double>& translate)
    : mVersor(std::move(versor)), mScale(scale), mTranslate(translate) {
  if (!std::isfinite(scale) || scale == 0 || !isFinite(translate))
    throw std::invalid_argument("a versor is scaled by " + textOf(scale) +
                                "; it must be a number other than 0, and it must be moved by finite numbers");
}

template <class Real>
void MovedVersor<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  QuaternionBatch<Real> at;
  at.resize(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) at.set(i, placedAt(q.get(i), mTranslate, mScale));
  mVersor->versor(at, u);
}

template <class Real>
void MovedVersor<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  std::vector<Ball> placed(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Ball ball = roundedTo<Real>(balls[i]);
    const double rounding = 8 * kEpsilonOf<Real> * (norm(ball.centre) + norm(mTranslate) + ball.radius);
    placed[i] = {placedAt(ball.centre, mTranslate, mScale),
                 (ball.radius + rounding) / std::abs(mScale) * (1 + kSlack) + kVanishing<Real>};
  }
  mVersor->cones(placed, cones);
}

void requireValid(const Symmetry& symmetry) {
  if (symmetry.fold < 1 || symmetry.fold > kMostFold)
    throw std::invalid_argument("a symmetry repeats a texture " + std::to_string(symmetry.fold) +
                                " times; it must be 1 to " + std::to_string(kMostFold));
  if (symmetry.axis < 0 || symmetry.axis > 2)
    throw std::invalid_argument("the axis of a symmetry is " + std::to_string(symmetry.axis) + "; it must be 0 to 2");
  for (const double x : symmetry.centre)
    if (!std::isfinite(x)) throw std::invalid_argument("the centre of a symmetry is not finite");
}

std::vector<SectorTurn> sectorTurns(int fold) {
  std::vector<SectorTurn> turns;
  for (int k = 0; k < fold; ++k) {
    // Whole quadrants of the rotation are exact.
    SectorTurn next{1, 0};
    const int whole = 4 * k / fold, rest = 4 * k % fold;
    kernels::sineCosine(static_cast<double>(rest) / fold, &next.sine, &next.cosine);
    for (int i = 0; i < whole; ++i) next = {-next.sine, next.cosine};
    turns.push_back(next);
  }
  return turns;
}

template <class Real>
SymmetricVersor<Real>::SymmetricVersor(std::shared_ptr<const VersorField<Real>> versor, const Symmetry& symmetry,
                                       DropAxis dropped)
    : mVersor(std::move(versor)), mSymmetry(symmetry), mEmbedding{.dropped = dropped} {
  requireValid(symmetry);
  mTurns = sectorTurns(symmetry.fold);
}

template <class Real>
template <class Number>
void SymmetricVersor<Real>::turn(Number& first, Number& second, const SectorTurn& by) {
  kernels::turnBy(static_cast<Number>(by.cosine), static_cast<Number>(by.sine), &first, &second);
}

template <class Real>
template <class Number>
Quaternion<Number> SymmetricVersor<Real>::turned(const Quaternion<Number>& q, const SectorTurn& by) const {
  std::array<Number, 3> at = mEmbedding.point(q);
  const std::size_t first = static_cast<std::size_t>(mSymmetry.axis + 1) % 3, second = (first + 1) % 3;
  for (const std::size_t axis : {first, second}) at[axis] -= static_cast<Number>(mSymmetry.centre[axis]);
  turn(at[first], at[second], by);
  for (const std::size_t axis : {first, second}) at[axis] += static_cast<Number>(mSymmetry.centre[axis]);
  return mEmbedding.put(q, at);
}

template <class Real>
template <class Number>
Quaternion<Number> SymmetricVersor<Real>::folded(const Quaternion<Number>& q) const {
  std::array<Number, 3> at = mEmbedding.point(q);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (mSymmetry.mirrored[axis]) at[axis] = kernels::mirroredUp(at[axis], static_cast<Number>(mSymmetry.centre[axis]));
  if (mSymmetry.kaleidoscope) {
    const std::size_t first = static_cast<std::size_t>(mSymmetry.axis + 1) % 3, second = (first + 1) % 3;
    Number x = at[first] - static_cast<Number>(mSymmetry.centre[first]);
    Number y = at[second] - static_cast<Number>(mSymmetry.centre[second]);
    // The sector with the nearest middle. On the border of two, either is valid.
    std::size_t nearest = 0;
    Number most = x;
    for (std::size_t k = 1; k < mTurns.size(); ++k) {
      const Number along =
          kernels::reachAlong(static_cast<Number>(mTurns[k].cosine), static_cast<Number>(mTurns[k].sine), x, y);
      if (along > most) {
        most = along;
        nearest = k;
      }
    }
    turn(x, y, mTurns[nearest]);
    at[first] = x + static_cast<Number>(mSymmetry.centre[first]);
    at[second] = kernels::magnitude(y) + static_cast<Number>(mSymmetry.centre[second]);
  }
  return mEmbedding.put(q, at);
}

template <class Real>
void SymmetricVersor<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  QuaternionBatch<Real> at, one;
  at.resize(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) at.set(i, folded(q.get(i)));
  if (mSymmetry.kaleidoscope || mTurns.size() == 1) return mVersor->versor(at, u);
  mVersor->versor(at, u);
  QuaternionBatch<Real> there;
  there.resize(q.size());
  for (std::size_t k = 1; k < mTurns.size(); ++k) {
    for (std::size_t i = 0; i < q.size(); ++i) there.set(i, turned(at.get(i), mTurns[k]));
    mVersor->versor(there, one);
    for (std::size_t i = 0; i < q.size(); ++i) u.set(i, u.get(i) + one.get(i));
  }
  for (std::size_t i = 0; i < q.size(); ++i) u.set(i, directionOf(u.get(i)));
}

/// How far the rotated position of a point of the ball, or of its centre, may be off.
template <class Real>
double SymmetricVersor<Real>::roundingOf(const Ball& ball) const {
  const Point& c = mSymmetry.centre;
  const double size = norm(ball.centre) + ball.radius + std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]);
  // Near the border of two sectors a point may be assigned to either, and the positions differ by as much once more.
  return 64 * kEpsilonOf<Real> * size + kVanishing<Real>;
}

template <class Real>
void SymmetricVersor<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  std::vector<Ball> at(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Ball ball = roundedTo<Real>(balls[i]);
    at[i] = {folded(ball.centre), ball.radius + roundingOf(ball)};
  }
  if (mSymmetry.kaleidoscope || mTurns.size() == 1) return mVersor->cones(at, cones);
  std::vector<Ball> sums(balls.size()), there(balls.size());
  for (const SectorTurn& by : mTurns) {
    for (std::size_t i = 0; i < balls.size(); ++i)
      there[i] = {turned(at[i].centre, by), at[i].radius + roundingOf(at[i])};
    mVersor->cones(there, cones);
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const Ball one = chordBall(cones[i]);
      sums[i] = {sums[i].centre + one.centre, (sums[i].radius + one.radius) * (1 + kSlack)};
    }
  }
  const double rounding = 32 * static_cast<double>(mTurns.size()) * kEpsilonOf<Real>;
  for (std::size_t i = 0; i < balls.size(); ++i) cones[i] = coneOf(sums[i], rounding);
}

template class MovedVersor<float>;
template class MovedVersor<double>;
template class SymmetricVersor<float>;
template class SymmetricVersor<double>;

}  // namespace julia
