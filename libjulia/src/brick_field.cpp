// SPDX-License-Identifier: Apache-2.0
#include "julia/brick_field.h"

#include "kernels/kernels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {

template <class Real>
struct BrickField<Real>::Lattice : kernels::BrickLattice<Real> {};

template <class Real>
BrickField<Real>::BrickField(std::shared_ptr<const Bricks> bricks, const BrickPlacement& placement)
    : mBricks(std::move(bricks)) {
  const std::size_t places = std::size_t{mBricks->count[0]} * mBricks->count[1] * mBricks->count[2];
  if (places == 0 || places > 0x7fffffff || places != mBricks->brickAt.size())
    throw std::invalid_argument("a lattice of " + std::to_string(places) + " bricks has " +
                                std::to_string(mBricks->brickAt.size()) + " places; both must be one number of 1 to " +
                                std::to_string(0x7fffffff));
  const std::size_t held = mBricks->values.size() / mBricks->size();
  if (*std::max_element(mBricks->brickAt.begin(), mBricks->brickAt.end()) >= held)
    throw std::invalid_argument("a brick is named that is not among the " + std::to_string(held) + " held");
  auto lattice = std::make_unique<Lattice>();
  for (std::size_t row = 0; row < 3; ++row) {
    const double end = mBricks->count[row] * double{kBrickSide};
    const double low = placement.low[row], high = placement.high[row];
    if (!(low >= 0 && high >= low && high + 0.5 < end))
      throw std::invalid_argument("positions from " + std::to_string(low) + " to " + std::to_string(high) +
                                  " do not lie within " + std::to_string(end) + " nodes");
    for (std::size_t column = 0; column < 3; ++column)
      lattice->matrix[row][column] = static_cast<Real>(placement.matrix[row][column]);
    lattice->offset[row] = static_cast<Real>(placement.offset[row]);
    lattice->low[row] = static_cast<Real>(low);
    lattice->high[row] = static_cast<Real>(high);
    lattice->bricks[row] = mBricks->count[row];
  }
  lattice->brickAt = mBricks->brickAt.data();
  lattice->values = mBricks->values.data();
  mLattice = std::move(lattice);
}

template <class Real>
BrickField<Real>::~BrickField() = default;

template <class Real>
void BrickField<Real>::sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
                              std::span<Real> out) const {
  const auto& table = kernels::kernels<Real>();
  const auto read = mBricks->interpolation == Interpolation::Quadratic ? table.sampleQuadratic : table.sampleTrilinear;
  read(*mLattice, x.data(), y.data(), z.data(), out.data(), out.size());
}

template class BrickField<float>;
template class BrickField<double>;

}  // namespace julia
