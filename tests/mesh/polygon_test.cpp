// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;

std::vector<Vec3I> triangulated(const std::vector<Vec3d>& points) {
  std::vector<std::uint32_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0U);
  std::vector<Vec3I> triangles;
  triangulatePolygon(corners, points, triangles);
  return triangles;
}

/// Twice the area vector of a polygon, as seen from its first corner.
Vec3d areaOf(const std::vector<Vec3d>& points) {
  Vec3d area(0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) area += (points[i] - points[0]).cross(points[i + 1] - points[0]);
  return area;
}

Vec3d areaOf(const std::vector<Vec3d>& points, const Vec3I& t) {
  return areaOf({points[t[0]], points[t[1]], points[t[2]]});
}

/// A polygon without crossings, seen from everywhere from its middle, in a plane of space that is not one of the axes'.
std::vector<Vec3d> star(std::size_t corners, std::mt19937& random) {
  std::uniform_real_distribution<double> radius(0.1, 1);
  const Vec3d across(0.6, 0, 0.8), along(0, 1, 0);
  std::vector<Vec3d> points;
  for (std::size_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners);
    points.push_back(Vec3d(5, -3, 2) + radius(random) * (std::cos(angle) * across + std::sin(angle) * along));
  }
  return points;
}

/// A comb: every second corner of its one side lies deep.
std::vector<Vec3d> comb(std::size_t teeth) {
  std::vector<Vec3d> points{{static_cast<double>(2 * teeth), -1, 0}};
  for (std::size_t i = 2 * teeth + 1; i-- > 0;) points.emplace_back(static_cast<double>(i), i % 2 ? 10.0 : 0.0, 0);
  points.emplace_back(0, -1, 0);
  return points;
}

/// The plainest ear clipping, cubic in the corners: cut the first corner off whose triangle holds no other corner.
std::vector<Vec3I> clippedSlowly(const std::vector<Vec3d>& points) {
  const Vec3d normal = areaOf(points);
  std::vector<std::uint32_t> ring(points.size());
  std::iota(ring.begin(), ring.end(), 0U);
  std::vector<Vec3I> triangles;
  const auto turn = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return (points[b] - points[a]).cross(points[c] - points[a]).dot(normal);
  };
  const auto isEar = [&](std::size_t i) {
    const std::size_t n = ring.size();
    const std::uint32_t a = ring[(i + n - 1) % n], b = ring[i], c = ring[(i + 1) % n];
    if (turn(a, b, c) <= 0) return false;
    for (const std::uint32_t p : ring) {
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  };
  while (ring.size() > 3) {
    std::size_t i = 0;
    while (i < ring.size() && !isEar(i)) ++i;
    if (i == ring.size()) break;
    const std::size_t n = ring.size();
    triangles.emplace_back(ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]);
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
  }
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) triangles.emplace_back(ring[0], ring[i], ring[i + 1]);
  return triangles;
}

void expectTiled(const std::vector<Vec3d>& points) {
  const Vec3d area = areaOf(points);
  const std::vector<Vec3I> triangles = triangulated(points);
  EXPECT_EQ(triangles.size(), points.size() - 2);
  // Triangles the right way round whose areas have the polygon's as their sum do not overlap.
  double sum = 0;
  for (const Vec3I& t : triangles) {
    const double one = areaOf(points, t).dot(area) / area.length();
    EXPECT_GE(one, -1e-12);
    sum += one;
  }
  EXPECT_NEAR(sum, area.length(), 1e-9 * area.length());
}

TEST(Polygon, IsTiledByItsTriangles) {
  std::mt19937 random(3);
  for (std::size_t corners = 3; corners < 40; ++corners) expectTiled(star(corners, random));
  expectTiled(star(400, random));
  expectTiled(comb(3));
  expectTiled(comb(150));
}

TEST(Polygon, HasTheEarsOfThePlainestClipping) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Vec3d> points = star(4 + random() % 30, random);
    // Half of them cross themselves and lie in no plane.
    if (trial % 2)
      for (Vec3d& p : points) p = {anywhere(random), anywhere(random), 0.2 * anywhere(random)};
    const std::vector<Vec3I> triangles = triangulated(points);
    // A polygon of which the fan is right the plain way has another triangulation, and needs no clipping.
    bool fan = true;
    for (std::size_t i = 0; i < triangles.size(); ++i)
      fan = fan && triangles[i] == Vec3I(0, Vec3I::ValueType(i + 1), Vec3I::ValueType(i + 2));
    if (!fan) {
      EXPECT_EQ(triangles, clippedSlowly(points)) << "trial " << trial;
    }
  }
  const std::vector<Vec3d> teeth = comb(40);
  EXPECT_EQ(triangulated(teeth), clippedSlowly(teeth));
}

}  // namespace
}  // namespace vdbtools
