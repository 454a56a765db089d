// SPDX-License-Identifier: Apache-2.0
#include "joined_bricks.h"

#include "brick_lattice.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

namespace julia {
namespace {

bool isOneLattice(const PlacedBricks& one, const PlacedBricks& other) {
  const BrickPlacement &a = one.placement, &b = other.placement;
  return one.bricks->count == other.bricks->count && a.matrix == b.matrix && a.offset == b.offset && a.low == b.low &&
         a.high == b.high && a.knee.at == b.knee.at && a.knee.more == b.knee.more;
}

}  // namespace

template <class Real>
std::unique_ptr<const JoinedBricks<Real>> JoinedBricks<Real>::of(const Fields& fields) {
  std::array<PlacedBricks, kernels::kJoinedFields> placed;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    std::optional<PlacedBricks> described = fields[k]->describe();
    if (!described || described->bricks->interpolation != Interpolation::Trilinear) return nullptr;
    placed[k] = std::move(*described);
    if (!isOneLattice(placed[0], placed[k])) return nullptr;
  }
  return std::unique_ptr<const JoinedBricks>(new JoinedBricks(placed));
}

template <class Real>
JoinedBricks<Real>::JoinedBricks(const std::array<PlacedBricks, kernels::kJoinedFields>& fields) {
  const Bricks& first = *fields[0].bricks;
  // Places share a brick here where they share one in each of the fields.
  using Numbers = std::array<std::uint32_t, kernels::kJoinedFields>;
  std::map<Numbers, std::uint32_t> numbered;
  std::vector<Numbers> bricks;
  mBrickAt.reserve(first.brickAt.size());
  for (std::size_t place = 0; place < first.brickAt.size(); ++place) {
    Numbers numbers;
    for (std::size_t k = 0; k < fields.size(); ++k) numbers[k] = fields[k].bricks->brickAt[place];
    const auto [known, isNew] = numbered.try_emplace(numbers, static_cast<std::uint32_t>(bricks.size()));
    if (isNew) bricks.push_back(numbers);
    mBrickAt.push_back(known->second);
  }
  const std::size_t nodes = first.size();
  mValues.resize(bricks.size() * nodes * fields.size() + (kernels::kJoinedWidth - kernels::kJoinedFields));
  float* to = mValues.data();
  for (const Numbers& numbers : bricks) {
    std::array<const float*, kernels::kJoinedFields> from;
    for (std::size_t k = 0; k < fields.size(); ++k) from[k] = fields[k].bricks->values.data() + numbers[k] * nodes;
    for (std::size_t node = 0; node < nodes; ++node)
      for (const float* values : from) *to++ = values[node];
  }
  placeLattice(fields[0].placement, first.count, mLattice);
  mLattice.brickAt = mBrickAt.data();
  mLattice.values = mValues.data();
}

template <class Real>
void JoinedBricks<Real>::sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
                                Real* const* out) const {
  kernels::kernels<Real>().sampleJoined(mLattice, x.data(), y.data(), z.data(), out, x.size());
}

template class JoinedBricks<float>;
template class JoinedBricks<double>;

}  // namespace julia
