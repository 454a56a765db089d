// SPDX-License-Identifier: Apache-2.0
/// @file brick_pyramid.h
/// Extremes of a brick field's values and slopes: for each brick, for boxes of bricks whose sizes double, and outside
/// spheres about the origin of space.
#pragma once

#include "julia/brick_field.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace julia {

struct BrickExtremes {
  float low = 0, high = 0;
  float slope = 0;  ///< the interpolant's steepest slope, per node

  void include(const BrickExtremes& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
    slope = std::max(slope, other.slope);
  }
};

class BrickPyramid {
 public:
  using Box = std::array<std::uint32_t, 3>;

  BrickPyramid(const Bricks& bricks, const BrickPlacement& placement);

  /// The extremes over all bricks from @a first to @a last and perhaps some adjacent ones. @pre first <= last <
  /// bricks.count
  BrickExtremes over(const Box& first, const Box& last) const;

  /// The smallest value that is read at points of space farther than this from the origin.
  double lowestBeyond(double distance) const;
  /// The largest magnitude of all values.
  double largest() const { return mLargest; }

 private:
  struct Level {
    Box count{};
    std::vector<BrickExtremes> cells;
  };
  void findLowestBeyond(const BrickPlacement& placement);
  /// @param level  0 for the bricks themselves
  const BrickExtremes& at(std::size_t level, std::size_t x, std::size_t y, std::size_t z) const {
    const Box& count = level == 0 ? mBricks.count : mLevels[level - 1].count;
    const std::size_t place = (x * count[1] + y) * count[2] + z;
    return level == 0 ? mOfBrick[mBricks.brickAt[place]] : mLevels[level - 1].cells[place];
  }

  const Bricks& mBricks;
  std::vector<BrickExtremes> mOfBrick;  ///< indexed by the number in brickAt
  std::vector<Level> mLevels;           ///< each cell of the first level covers 2^3 bricks
  double mLargest = 0;
  double mStep = 0;                  ///< step of the distances, units of space; 0 if nothing is known
  std::vector<float> mLowestBeyond;  ///< entry k: beyond k steps; the last entry covers everything farther out
};

}  // namespace julia
