// SPDX-License-Identifier: Apache-2.0
/// @file brick_field.h
/// A scalar field on a sparse regular lattice, read at scattered points. Its values lie in bricks (bricks.h).
#pragma once

#include "julia/bricks.h"
#include "julia/scalar_field.h"

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

namespace julia {

class BrickPyramid;

/// Reads bricks in the type Real. Each read interpolates the stored values and gives the same bits with every
/// instruction set.
template <class Real>
class BrickField final : public ScalarField<Real> {
 public:
  /// @throw std::invalid_argument if the sizes do not match, or if the box is not within the bricks
  BrickField(std::shared_ptr<const Bricks> bricks, const BrickPlacement& placement);
  ~BrickField() override;

  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override;

  /// Computes bounds from the extremes of the bricks that the ball touches, and from the value at its centre and the
  /// steepest slope there. The first call visits all bricks once.
  void ranges(std::span<const std::array<double, 3>> centres, std::span<const double> radii,
              std::span<ValueRange> out) const override;
  double lowestBeyond(double distance) const override;
  std::optional<PlacedBricks> describe() const override { return PlacedBricks{mBricks, mPlacement}; }

 private:
  struct Lattice;
  const BrickPyramid& pyramid() const;
  ValueRange rangeAbout(Real value, const std::array<double, 3>& centre, double radius) const;
  std::shared_ptr<const Bricks> mBricks;
  std::unique_ptr<const Lattice> mLattice;
  BrickPlacement mPlacement;
  mutable std::once_flag mPyramidMade;
  mutable std::unique_ptr<const BrickPyramid> mPyramid;
};

extern template class BrickField<float>;
extern template class BrickField<double>;

}  // namespace julia
