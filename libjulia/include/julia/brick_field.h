// SPDX-License-Identifier: Apache-2.0
/// @file brick_field.h
/// A scalar field on a sparse regular lattice, laid out for reading at scattered points: bricks of 8^3 lattice cells,
/// each with copies of its neighbours' nearest values, so that a read stays within one brick.
#pragma once

#include "julia/scalar_field.h"

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace julia {

enum class Interpolation {
  Trilinear,  ///< continuous; its slope jumps between cells, which shows as creases in deep zooms
  Quadratic,  ///< the quadratic B-spline: its slope is continuous too, and it smooths the values a little. Between the
              ///< smallest and the largest of the 3^3 values around the point
};

inline constexpr std::uint32_t kBrickSide = 8;

/// Lattice values, filled by whoever has them. Brick (x, y, z) owns the nodes from 8 (x, y, z) on.
struct Bricks {
  Interpolation interpolation = Interpolation::Trilinear;
  std::array<std::uint32_t, 3> count{};  ///< bricks along each axis
  std::vector<std::uint32_t> brickAt;    ///< which brick, by (x count[1] + y) count[2] + z
  std::vector<float> values;             ///< finite, side()^3 a brick, z running fastest

  /// Nodes before and behind the brick's own 8 that it holds copies of.
  std::uint32_t before() const { return interpolation == Interpolation::Quadratic ? 1 : 0; }
  std::uint32_t side() const { return kBrickSide + before() + 1; }
  std::size_t size() const { return std::size_t{side()} * side() * side(); }
};

/// Node coordinates from a point: matrix times point plus offset.
struct BrickPlacement {
  std::array<std::array<double, 3>, 3> matrix{};
  std::array<double, 3> offset{};
  std::array<double, 3> low{}, high{};  ///< positions are clamped to this box, which lies within the bricks
};

class BrickPyramid;

/// Reads in @a Real. All reads are exact: the interpolant of the stored values, whatever the instruction set.
template <class Real>
class BrickField final : public ScalarField<Real> {
 public:
  /// @throw std::invalid_argument if the sizes do not fit each other, or the box is not within the bricks
  BrickField(std::shared_ptr<const Bricks> bricks, const BrickPlacement& placement);
  ~BrickField() override;

  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override;

  /// From the extremes of the bricks that the ball touches, and from the value at its centre and the steepest slope
  /// there. The first call goes through all bricks once.
  void ranges(std::span<const std::array<double, 3>> centres, std::span<const double> radii,
              std::span<ValueRange> out) const override;
  double lowestBeyond(double distance) const override;

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
