// SPDX-License-Identifier: Apache-2.0
/// @file brick_pyramid.h
/// Extremes of a brick field's values and slopes: of each brick, of boxes of bricks that double in size, and outside
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
  float slope = 0;  ///< the interpolant's steepest, a node

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

  /// Of all bricks from @a first to @a last and perhaps some beside these. @pre first <= last < bricks.count
  BrickExtremes over(const Box& first, const Box& last) const;

  /// The least value that is read at points of space farther than this from the origin.
  double lowestBeyond(double distance) const;
  /// Of all magnitudes of values.
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
  std::vector<BrickExtremes> mOfBrick;  ///< by the number in brickAt
  std::vector<Level> mLevels;           ///< the first holds a cell for 2^3 places
  double mLargest = 0;
  double mStep = 0;                  ///< of distances, units of space; 0 if nothing is known
  std::vector<float> mLowestBeyond;  ///< from a whole number of steps on; the last for all beyond
};

}  // namespace julia
