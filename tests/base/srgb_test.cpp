// SPDX-License-Identifier: Apache-2.0
#include "base/srgb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace {

using vdbtools::linearFromSrgb;
using vdbtools::srgbCode;
using vdbtools::srgbFromLinear;

TEST(Srgb, CodesComeBack) {
  for (int code = 0; code < 256; ++code) {
    const float encoded = static_cast<float>(code) / 255;
    EXPECT_EQ(srgbCode(linearFromSrgb(encoded)), code);
    EXPECT_NEAR(srgbFromLinear(linearFromSrgb(encoded)), encoded, 1e-6F);
  }
}

TEST(Srgb, CodesAreTheNearest) {
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    const float linear = static_cast<float>(random() >> 8) * 0x1p-24F;
    ASSERT_EQ(srgbCode(linear), std::lround(255 * srgbFromLinear(linear))) << linear;
  }
}

TEST(Srgb, WhatIsOutOfRangeIsClamped) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(srgbCode(-0.5F), 0);
  EXPECT_EQ(srgbCode(-0.0F), 0);
  EXPECT_EQ(srgbCode(1.5F), 255);
  EXPECT_EQ(srgbCode(std::numeric_limits<float>::max()), 255);
  for (const float none : {kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_EQ(srgbCode(none), 0);
}

}  // namespace
