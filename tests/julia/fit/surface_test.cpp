// SPDX-License-Identifier: Apache-2.0
// Points on a surface: on it, evenly, in an order whose beginnings are even too.
#include "julia/fit/surface.h"

#include "support/fit_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace {

using julia::area;
using julia::blueNoise;
using julia::Point;
using julia::TriangleSurface;
using law_tests::cube;
using law_tests::distance;
using law_tests::norm;
using law_tests::sphere;
using law_tests::stretched;

double leastDistance(const std::vector<Point>& points, std::size_t count) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, distance(points[i], points[j]));
  return least;
}

/// The distance of @a count points in the densest packing of an area.
double densest(double wholeArea, std::size_t count) {
  return std::sqrt(2 * wholeArea / (std::sqrt(3.) * static_cast<double>(count)));
}

TEST(Area, isThatOfTheShape) {
  EXPECT_NEAR(area(cube(7, 2)), 6, 1e-13);
  EXPECT_NEAR(area(stretched(cube(3), {2, 3, 5})), 62, 1e-12);
  EXPECT_NEAR(area(sphere(4)), 4 * std::numbers::pi, 0.02);
  EXPECT_EQ(area({}), 0);
  EXPECT_EQ(area({{{1, 2, 3}}, {{0, 0, 0}}}), 0);
}

TEST(BlueNoise, liesOnTheSurface) {
  for (const Point& x : blueNoise(cube(3), 1000, 1)) {
    double toFace = 1;
    for (const double coordinate : x) {
      EXPECT_GE(coordinate, -1e-15);
      EXPECT_LE(coordinate, 1 + 1e-15);
      toFace = std::min({toFace, std::abs(coordinate), std::abs(1 - coordinate)});
    }
    EXPECT_LT(toFace, 1e-15);
  }
}

// Poisson's own points come within a hundredth of the densest packing's distance; those of Yuksel's paper keep 0.7 of
// it.
TEST(BlueNoise, keepsItsDistanceInEveryPrefix) {
  for (const TriangleSurface& surface : {cube(1), cube(20, 3), sphere(3), stretched(sphere(3), {1, 1, 5})}) {
    const double whole = area(surface);
    const std::vector<Point> points = blueNoise(surface, 3000, 7);
    ASSERT_EQ(points.size(), 3000U);
    for (const std::size_t count : {3000, 2000, 1500, 1000, 750, 500, 300, 187, 100, 50, 20})
      EXPECT_GT(leastDistance(points, count) / densest(whole, count), count == 3000 ? 0.65 : 0.5)
          << count << " points on " << surface.triangles.size() << " triangles";
  }
}

TEST(BlueNoise, coversEvenly) {
  const std::vector<Point> points = blueNoise(sphere(3), 4000, 3);
  // Caps of equal height have equal area: deviations of random points would be sqrt(400 * 0.9) = 19.
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<int> caps(10);
    for (const Point& x : points) ++caps[std::clamp(static_cast<int>((x[axis] / norm(x) + 1) * 5), 0, 9)];
    for (const int count : caps) EXPECT_NEAR(count, 400, 25) << axis;
  }
  // No hole either: somebody within the densest packing's distance of any place.
  double farthest = 0;
  for (const Point& x : sphere(4).points) {
    double nearest = 2;
    for (const Point& point : points) nearest = std::min(nearest, distance(x, point));
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, densest(4 * std::numbers::pi, 4000));
}

// Promise: "Every seed is in the recipe", and no library ...
TEST(BlueNoise, seedDecides) {
  const TriangleSurface surface = sphere(2);
  EXPECT_EQ(blueNoise(surface, 500, 1), blueNoise(surface, 500, 1));
  EXPECT_NE(blueNoise(surface, 500, 1), blueNoise(surface, 500, 2));
}

TEST(BlueNoise, fewPointsAndPoorTriangles) {
  const TriangleSurface one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  for (const std::size_t count : {1, 2, 3, 4, 5}) EXPECT_EQ(blueNoise(one, count, 1).size(), count);
  // Without area in between, without width, and with coordinates that are large for their differences.
  const TriangleSurface poor{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e6, 0, 1e-9}, {1e9, 1e9, 1e9}},
                             {{0, 0, 1}, {0, 1, 2}, {2, 2, 2}, {0, 1, 3}}};
  EXPECT_EQ(blueNoise(poor, 100, 1).size(), 100U);
  EXPECT_EQ(blueNoise(stretched(cube(2), {1e9, 1e-9, 1e-9}), 300, 1).size(), 300U);
  EXPECT_GT(leastDistance(blueNoise(stretched(sphere(3), {1e-9, 1e-9, 1e-9}), 500, 1), 500), 1e-11);
}

TEST(BlueNoise, refusesNonsense) {
  const auto expectThrow = [](TriangleSurface surface, std::size_t count, const char* what) {
    EXPECT_THROW(blueNoise(surface, count, 1), std::invalid_argument) << what;
  };
  const TriangleSurface good = sphere(1);
  expectThrow(good, 0, "count 0");
  expectThrow(good, 1'000'000'000, "count 1e9");
  expectThrow({}, 5, "nothing");
  expectThrow({good.points, {}}, 5, "no triangles");
  expectThrow({{{1, 2, 3}}, {{0, 0, 0}}}, 5, "no area");
  TriangleSurface bad = good;
  bad.triangles[3][1] = 42;
  expectThrow(bad, 5, "index");
  for (const double number :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.1e9}) {
    bad = good;
    bad.points[3][1] = number;
    expectThrow(bad, 5, "coordinate");
  }
}

}  // namespace
