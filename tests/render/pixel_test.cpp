// SPDX-License-Identifier: Apache-2.0
#include "render/shading.h"
#include "render/view.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

namespace {

using openvdb::Vec3d;
using vdbtools::PixelSamples;
using vdbtools::preview::KeyLight;
using vdbtools::preview::Pixel;
using vdbtools::preview::Shown;

/// Where a sample lies in its pixel: to the right and down, from 0 to 1.
std::array<double, 2> within(const PixelSamples& samples, int width, int height, int x, int y, int s) {
  const auto [u, v] = samples.at(x, y, s);
  return {(u + 1) / 2 * width - x, (1 - v) / 2 * height - y};
}

TEST(PixelSamples, ALatticeAndAsManyAgainAtOtherHeights) {
  for (const int n : {1, 2, 3, 4}) {
    const PixelSamples samples(7, 5, n * n);
    ASSERT_EQ(samples.usual(), n * n);
    std::set<int> cells, rows, columns;
    double right = 0, down = 0;
    for (int s = 0; s < 2 * n * n; ++s) {
      const auto [x, y] = within(samples, 7, 5, 3, 4, s);
      if (s == n * n) {
        EXPECT_EQ(cells.size(), static_cast<std::size_t>(n * n));
        cells.clear();
      }
      cells.insert(static_cast<int>(x * n) * n + static_cast<int>(y * n));
      right += x;
      down += y;
      if (s < n * n) continue;
      rows.insert(static_cast<int>(std::floor(y * n * n)));
      columns.insert(static_cast<int>(std::floor(x * n * n)));
    }
    // One in each part of the pixel, both times; those of the second time in rows and columns of their own.
    EXPECT_EQ(cells.size(), static_cast<std::size_t>(n * n));
    EXPECT_EQ(rows.size(), static_cast<std::size_t>(n * n));
    EXPECT_EQ(columns.size(), static_cast<std::size_t>(n * n));
    EXPECT_NEAR(right / (2 * n * n), 0.5, 1e-9) << "a picture does not move where it is rough";
    EXPECT_NEAR(down / (2 * n * n), 0.5, 1e-9);
  }
}

Shown hit(double grey, double distance = 1) {
  return {.colour = Vec3d(grey), .alpha = 1, .hits = 1, .distance = distance};
}

TEST(Pixel, IsRoughAtAnEdgeAndWhereItsLightnessVaries) {
  const auto isRough = [](std::initializer_list<Shown> seen) {
    Pixel pixel;
    for (const Shown& each : seen) pixel.add(each, Vec3d(0, 0, 1));
    return pixel.isRough();
  };
  const Shown white{.colour = Vec3d(1), .alpha = 1}, nothing{};
  EXPECT_FALSE(isRough({hit(0.3), hit(0.31), hit(0.3), hit(0.29)}));
  EXPECT_TRUE(isRough({hit(0.05), hit(0.6), hit(0.3), hit(0.29)}));
  EXPECT_TRUE(isRough({hit(0.3), hit(0.3), hit(0.3), white})) << "the surface ends here";
  EXPECT_TRUE(isRough({hit(0.3), hit(0.3), hit(0.3), nothing})) << "whatever is behind it";
  EXPECT_FALSE(isRough({white, nothing, white, nothing})) << "what is behind does not count";
  EXPECT_FALSE(isRough({hit(3), hit(30)})) << "both are white on the screen";
  EXPECT_FALSE(isRough({hit(0.3)}));
}

TEST(Pixel, IsTheMeanAndHasWhatIsNearest) {
  Pixel pixel;
  Shown near = hit(0.8, 2), far = hit(0.2, 3);
  near.trap = 7;
  pixel.add(far, Vec3d(1, 0, 0));
  pixel.add(near, Vec3d(0, 1, 0));
  pixel.add({}, Vec3d(0, 0, 1));
  pixel.add(far, Vec3d(1, 0, 0));
  const Shown shown = pixel.shown();
  EXPECT_NEAR(shown.colour[0], (0.8 + 0.2 + 0.2) / 4, 1e-12);
  EXPECT_NEAR(shown.alpha, 0.75, 1e-12);
  EXPECT_EQ(shown.hits, 3);
  EXPECT_EQ(shown.distance, 2);
  EXPECT_EQ(shown.trap, 7);
  EXPECT_EQ(pixel.direction(), Vec3d(0, 1, 0));
}

TEST(KeyLight, IsSettledByRaysThatAgree) {
  for (const bool blocked : {false, true}) {
    KeyLight light;
    for (int i = 0; i < 7; ++i) light.add(blocked);
    EXPECT_FALSE(light.isSettled());
    light.add(blocked);
    EXPECT_TRUE(light.isSettled());
    light.add(!blocked);
    EXPECT_FALSE(light.isSettled());
  }
}

}  // namespace
