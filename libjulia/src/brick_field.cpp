// SPDX-License-Identifier: Apache-2.0
#include "julia/brick_field.h"

#include "julia/norm_bound.h"

#include "ball_arithmetic.h"
#include "brick_lattice.h"
#include "brick_pyramid.h"
#include "kernels/kernels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {

template <class Real>
struct BrickField<Real>::Lattice : kernels::BrickLattice<Real> {
  double stretch = 0;  ///< upper bound of nodes per unit of space

  /// Applies the knee to a bound of interpolated values. Rounding keeps the order, so the result bounds the values that
  /// are read.
  double bent(double bound) const {
    if (!(this->more > 0)) return bound;
    const Real v = static_cast<Real>(bound);
    return static_cast<double>(v + this->more * std::min(v - this->knee, Real(0)));
  }
};

template <class Real>
BrickField<Real>::BrickField(std::shared_ptr<const Bricks> bricks, const BrickPlacement& placement)
    : mBricks(std::move(bricks)), mPlacement(placement) {
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
  }
  placeLattice<Real>(placement, mBricks->count, *lattice);
  std::array<std::array<double, 3>, 3> rounded{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t k = 0; k < 3; ++k) rounded[row][k] = static_cast<double>(lattice->matrix[row][k]);
  lattice->stretch = normBound(rounded) * (1 + kSlack);
  if (!(placement.knee.more >= 0))
    throw std::invalid_argument("below its knee a field has " + std::to_string(placement.knee.more) +
                                " more slope; it must be 0 or more");
  lattice->brickAt = mBricks->brickAt.data();
  lattice->values = mBricks->values.data();
  mLattice = std::move(lattice);
}

template <class Real>
BrickField<Real>::~BrickField() = default;

namespace {

template <class Real>
auto readOf(Interpolation interpolation) {
  const auto& table = kernels::kernels<Real>();
  return interpolation == Interpolation::Quadratic ? table.sampleQuadratic : table.sampleTrilinear;
}

}  // namespace

template <class Real>
void BrickField<Real>::sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
                              std::span<Real> out) const {
  readOf<Real>(mBricks->interpolation)(*mLattice, x.data(), y.data(), z.data(), out.data(), out.size());
}

template <class Real>
const BrickPyramid& BrickField<Real>::pyramid() const {
  std::call_once(mPyramidMade, [this] { mPyramid = std::make_unique<const BrickPyramid>(*mBricks, mPlacement); });
  return *mPyramid;
}

template <class Real>
void BrickField<Real>::ranges(std::span<const std::array<double, 3>> centres, std::span<const double> radii,
                              std::span<ValueRange> out) const {
  std::vector<Real> x(centres.size()), y(centres.size()), z(centres.size()), values(centres.size());
  for (std::size_t i = 0; i < centres.size(); ++i) {
    x[i] = static_cast<Real>(centres[i][0]);
    y[i] = static_cast<Real>(centres[i][1]);
    z[i] = static_cast<Real>(centres[i][2]);
  }
  kernels::BrickLattice<Real> straight = *mLattice;
  straight.more = 0;
  readOf<Real>(mBricks->interpolation)(straight, x.data(), y.data(), z.data(), values.data(), values.size());
  for (std::size_t i = 0; i < centres.size(); ++i) out[i] = rangeAbout(values[i], centres[i], radii[i]);
}

/// @param value  the interpolated value at the centre
template <class Real>
ValueRange BrickField<Real>::rangeAbout(Real value, const std::array<double, 3>& centre, double radius) const {
  constexpr double eps = kEpsilonOf<Real>;
  const Lattice& lattice = *mLattice;
  // Three products and three sums of coordinates that are rounded to Real, including the centre's: 4 eps of the sum of
  // magnitudes. The spline's shift by half a node adds one more.
  constexpr double kPositionRounding = 4 * eps;
  const double nodes = lattice.stretch * radius * (1 + kSlack);
  const double half = mBricks->interpolation == Interpolation::Quadratic ? 0.5 : 0;
  BrickPyramid::Box first{}, last{};
  double rounding = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    double position = static_cast<double>(lattice.offset[row]), size = std::abs(position) + 1 + nodes;
    for (std::size_t k = 0; k < 3; ++k) {
      const double term = static_cast<double>(lattice.matrix[row][k]) * centre[k];
      position += term;
      size += std::abs(term);
    }
    const double off = kPositionRounding * size, reach = nodes + off;
    if (!(std::abs(position) + reach < std::numeric_limits<double>::max())) return {};
    rounding = std::max(rounding, off);
    const double low = static_cast<double>(lattice.low[row]), high = static_cast<double>(lattice.high[row]);
    const double slack = 2 * eps * (high + 1);
    const auto brick = [&](double node) {
      const double inside = std::max(node, 0.) * (1. / kBrickSide);
      return std::min(static_cast<std::uint32_t>(inside), lattice.bricks[row] - 1);
    };
    first[row] = brick(std::clamp(position - reach, low, high) + half - slack);
    last[row] = brick(std::clamp(position + reach, low, high) + half + slack);
  }
  const BrickExtremes extremes = pyramid().over(first, last);
  // An interpolant is a mean of values, accurate to about 12 eps of the largest.
  const double least = static_cast<double>(extremes.low), most = static_cast<double>(extremes.high);
  const double off = 16 * eps * std::max(std::abs(least), std::abs(most));
  // Positions are clamped to a box, which never increases a distance; the centre's position is rounded, too.
  const double distance = nodes + 2 * std::sqrt(3.) * rounding;
  const double rise = static_cast<double>(extremes.slope) * distance * (1 + kSlack) + 2 * off;
  return {lattice.bent(std::max(least - off, static_cast<double>(value) - rise)),
          lattice.bent(std::min(most + off, static_cast<double>(value) + rise))};
}

template <class Real>
double BrickField<Real>::lowestBeyond(double distance) const {
  // The pyramid allows for positions that are off by half a node.
  double size = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    size = std::max(size, std::abs(mPlacement.offset[axis]) + mPlacement.high[axis]);
  if (!(64 * kEpsilonOf<Real> * size < 0.5)) return -std::numeric_limits<double>::infinity();
  const double low = pyramid().lowestBeyond(distance * (1 - 8 * kEpsilonOf<Real>));
  return mLattice->bent(low - 16 * kEpsilonOf<Real> * pyramid().largest());
}

template class BrickField<float>;
template class BrickField<double>;

}  // namespace julia
