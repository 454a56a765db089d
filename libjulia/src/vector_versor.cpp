// SPDX-License-Identifier: Apache-2.0
#include "julia/vector_versor.h"

#include "cone_arithmetic.h"

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace julia {

template <class Real>
VectorVersor<Real>::VectorVersor(std::vector<std::shared_ptr<const ScalarField<Real>>> components, DropAxis dropped)
    : mComponents(std::move(components)), mEmbedding{.dropped = dropped} {
  if (mComponents.size() != 3 && mComponents.size() != 4)
    throw std::invalid_argument("a field of directions has " + std::to_string(mComponents.size()) +
                                " components; it must have three or four");
  constexpr Quaternion<std::size_t> kNumbers{0, 1, 2, 3};
  if (mComponents.size() == 4) {
    mPlaces = {0, 1, 2, 3};
  } else {
    const std::array<std::size_t, 3> places = mEmbedding.point(kNumbers);
    mPlaces.assign(places.begin(), places.end());
  }
}

template <class Real>
void VectorVersor<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  u.resize(q.size());
  const std::array<std::vector<Real>*, 4> parts{&u.a, &u.b, &u.c, &u.d};
  for (std::vector<Real>* part : parts) std::fill(part->begin(), part->end(), Real(0));
  const auto [x, y, z] = mEmbedding.point(Quaternion<std::span<const Real>>{q.a, q.b, q.c, q.d});
  for (std::size_t k = 0; k < mComponents.size(); ++k) mComponents[k]->sample(x, y, z, *parts[mPlaces[k]]);
  for (std::size_t i = 0; i < q.size(); ++i) u.set(i, directionOf(u.get(i)));
}

template <class Real>
void VectorVersor<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  const BallsInSpace space(roundedTo<Real>(balls), mEmbedding);
  std::vector<std::array<ValueRange, 4>> boxes(balls.size(), {ValueRange{0, 0}, {0, 0}, {0, 0}, {0, 0}});
  std::vector<ValueRange> ranges(balls.size());
  for (std::size_t k = 0; k < mComponents.size(); ++k) {
    space.rangesOf(*mComponents[k], ranges);
    for (std::size_t i = 0; i < balls.size(); ++i) boxes[i][mPlaces[k]] = ranges[i];
  }
  for (std::size_t i = 0; i < balls.size(); ++i) {
    std::array<double, 4> middle{};
    double square = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [low, high] = boxes[i][k];
      middle[k] = (low + high) / 2;
      square += (high - low) * (high - low) / 4;
    }
    const Ball ball{{middle[0], middle[1], middle[2], middle[3]}, std::sqrt(square)};
    // Components that are small compared with the largest may have lost digits, but not relative to the length.
    const double rounding = 32 * kEpsilonOf<Real>;
    cones[i] =
        std::isfinite(square) ? coneOf({ball.centre, ball.radius * (1 + kSlack) + kVanishing<Real>}, rounding) : Cone{};
  }
}

template class VectorVersor<float>;
template class VectorVersor<double>;

}  // namespace julia
