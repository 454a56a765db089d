// SPDX-License-Identifier: Apache-2.0
/// @file bricks.h
/// The values of a scalar field on a sparse regular lattice, as plain data: bricks of 8^3 lattice cells, each with
/// copies of its neighbours' nearest values, so that a read stays within one brick. brick_field.h reads them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace julia {

enum class Interpolation {
  Trilinear,  ///< continuous; its slope jumps between cells, which shows as creases in deep zooms
  Quadratic,  ///< the quadratic B-spline: its slope is continuous too, but it smooths the values a little. The result
              ///< lies between the smallest and the largest of the 3^3 values around the point
};

inline constexpr std::uint32_t kBrickSide = 8;

/// Lattice values, filled in by the caller. Brick (x, y, z) owns the nodes from 8 (x, y, z) on.
struct Bricks {
  Interpolation interpolation = Interpolation::Trilinear;
  std::array<std::uint32_t, 3> count{};  ///< bricks along each axis
  std::vector<std::uint32_t> brickAt;    ///< the brick at each place, indexed by (x count[1] + y) count[2] + z
  std::vector<float> values;             ///< finite; side()^3 for each brick, z running fastest

  /// The number of copied nodes in front of the brick's own 8, along each axis.
  std::uint32_t before() const { return interpolation == Interpolation::Quadratic ? 1 : 0; }
  /// Values along a brick's edge; one copied node follows the brick's own.
  std::uint32_t side() const { return kBrickSide + before() + 1; }
  std::size_t size() const { return std::size_t{side()} * side() * side(); }
};

/// A bend in the values that are read: an interpolated v becomes v + more min(v - at, 0).
struct Knee {
  double at = 0;
  double more = 0;  ///< by how much the slope below the knee exceeds that above it, >= 0
};

/// Where the lattice lies, and how it is read. A point's position in nodes is matrix times point plus offset.
struct BrickPlacement {
  std::array<std::array<double, 3>, 3> matrix{};
  std::array<double, 3> offset{};
  std::array<double, 3> low{}, high{};  ///< positions are clamped to this box, which lies within the bricks
  Knee knee{};
};

/// A field that is read from bricks.
struct PlacedBricks {
  std::shared_ptr<const Bricks> bricks;
  BrickPlacement placement;
};

}  // namespace julia
