// SPDX-License-Identifier: Apache-2.0
/// @file lumpy_bricks.h
/// An exponent in bricks: twelve times the distance to a ball with lumps.
#pragma once

#include "julia/bricks.h"

#include <cmath>
#include <cstdint>
#include <memory>

namespace law_tests {

/// A ball with lumps, as bricks about the origin.
inline julia::PlacedBricks lumpyBricks(julia::Interpolation interpolation) {
  constexpr std::uint32_t kAcross = 5, kNodes = 33;
  constexpr double kSpacing = 1. / 24, kHalf = kSpacing * (kNodes - 1) / 2;
  auto bricks = std::make_shared<julia::Bricks>();
  bricks->interpolation = interpolation;
  bricks->count = {kAcross, kAcross, kAcross};
  const auto coordinate = [&](std::uint32_t brick, std::uint32_t k) {
    return kSpacing * (static_cast<double>(brick * julia::kBrickSide + k) - bricks->before()) - kHalf;
  };
  for (std::uint32_t place = 0; place < kAcross * kAcross * kAcross; ++place) {
    bricks->brickAt.push_back(place);
    for (std::uint32_t i = 0; i < bricks->side(); ++i)
      for (std::uint32_t j = 0; j < bricks->side(); ++j)
        for (std::uint32_t k = 0; k < bricks->side(); ++k) {
          const double x = coordinate(place / (kAcross * kAcross), i), y = coordinate(place / kAcross % kAcross, j);
          const double z = coordinate(place % kAcross, k);
          const double phi = std::sqrt(x * x + y * y + z * z) - 0.375 - 0.04 * std::sin(8 * x) * std::sin(9 * y);
          bricks->values.push_back(static_cast<float>(12 * phi));
        }
  }
  julia::BrickPlacement placement{.knee = {.at = -1.2, .more = 2.5}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    placement.matrix[axis][axis] = 1 / kSpacing;
    placement.offset[axis] = kHalf / kSpacing;
    placement.high[axis] = kNodes - 1;
  }
  return {bricks, placement};
}

}  // namespace law_tests
