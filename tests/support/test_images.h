// SPDX-License-Identifier: Apache-2.0
/// @file test_images.h
/// What the tests of pictures share: plain colours, and how far two pictures differ.
#pragma once

#include "vdbtools/picture/image.h"

#include <cmath>
#include <cstddef>

namespace test_images {

inline constexpr vdbtools::Colour kWhite{1, 1, 1}, kBlack{}, kRed{1, 0, 0};

/// The mean difference of the pixels' channels.
inline double difference(const vdbtools::Image& a, const vdbtools::Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(a.pixels[i][c] - b.pixels[i][c]);
  return sum / (3.0 * static_cast<double>(a.pixels.size()));
}

}  // namespace test_images
