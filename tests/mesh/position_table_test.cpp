// SPDX-License-Identifier: Apache-2.0
#include "mesh/position_table.h"

#include "support/test_meshes.h"
#include "vdbtools/mesh/mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

namespace {

using openvdb::Vec3d;
using vdbtools::PositionTable;

/// Points that a hash without a key, which JuliaVDB once had, puts into one place of every table of up to 2^32 entries:
/// each of its steps can be undone, so the last coordinate follows from the hash that is wanted.
std::vector<Vec3d> collidingPoints(std::size_t count) {
  constexpr std::uint64_t kFactor = 0x9E3779B97F4A7C15U;
  std::uint64_t inverse = kFactor;  // modulo 2^64, by Newton's iteration
  for (int i = 0; i < 6; ++i) inverse *= 2 - kFactor * inverse;
  const auto step = [](std::uint64_t hash, double coordinate) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate)) * kFactor;
    return hash ^ (hash >> 29);
  };
  std::vector<Vec3d> points;
  for (std::uint64_t wanted = std::uint64_t{1} << 32; points.size() < count; wanted += std::uint64_t{1} << 32) {
    const double x = static_cast<double>(points.size());
    const std::uint64_t before = step(step(0, x), 0.0);
    const double z = std::bit_cast<double>(((wanted ^ (wanted >> 29) ^ (wanted >> 58)) * inverse) ^ before);
    if (!std::isfinite(z) || z == 0 || step(before, z) != wanted) continue;
    points.emplace_back(x, 0.0, z);
  }
  return points;
}

/// Multiples of a number: tables whose size it divides put them into one place, where numbers are their own hash.
std::vector<Vec3d> latticePoints(int side) {
  std::vector<Vec3d> points;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z) points.emplace_back(1024 * x, 1024 * y, 1024 * z);
  return points;
}

// Promise of reliability.md: "No file can make the welding of its points quadratic"
TEST(PositionTable, ComparesFewPairsWhateverTheFile) {
  for (const std::vector<Vec3d>& points : {collidingPoints(200000), latticePoints(50)}) {
    std::vector<Vec3d> places;
    PositionTable table(places, points.size());
    for (int round = 0; round < 2; ++round)
      for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(table.numberOf(points[i]), i);
    EXPECT_EQ(places.size(), points.size());
    EXPECT_LT(table.comparisons(), 20 * points.size());
  }
}

TEST(PositionTable, NumbersPlacesAsTheyComeFirst) {
  std::vector<Vec3d> points = collidingPoints(1000);
  const std::vector<Vec3d> lattice = latticePoints(6);
  points.insert(points.end(), lattice.begin(), lattice.end());
  std::vector<Vec3d> all = points;
  for (std::size_t i = 0; i < points.size(); ++i) all.push_back(points[i * 7919 % points.size()]);
  all.emplace_back(-0.0, 0.0, -0.0);
  // Each round draws another key.
  for (int round = 0; round < 3; ++round) {
    std::map<std::array<double, 3>, std::uint32_t> expected;  // in which -0 is 0, too
    std::vector<Vec3d> places;
    PositionTable table(places, all.size());
    for (const Vec3d& p : all) {
      const auto [known, isNew] = expected.try_emplace({p[0], p[1], p[2]}, static_cast<std::uint32_t>(expected.size()));
      ASSERT_EQ(table.numberOf(p), known->second);
    }
    EXPECT_EQ(places.size(), expected.size());
  }
}

// Promise: "No file can make the welding ..."
TEST(WeldMesh, TakesAMeshWhosePointsWereChosenToCollide) {
  vdbtools::Mesh mesh;
  mesh.points = collidingPoints(200000);
  for (std::uint32_t i = 0; i + 2 < mesh.points.size(); ++i) mesh.triangles.emplace_back(i, i + 1, i + 2);
  const vdbtools::Mesh welded = vdbtools::weldMesh(test_meshes::makeSoup(mesh, 0));
  EXPECT_EQ(welded.points.size(), mesh.points.size());
  EXPECT_EQ(welded.triangles.size(), mesh.triangles.size());
}

}  // namespace
