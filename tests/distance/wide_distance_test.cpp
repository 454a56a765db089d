// SPDX-License-Identifier: Apache-2.0
#include "distance/wide_distance.h"

#include "distance/known_distance.h"
#include "support/test_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::Vec3d;

double ball(const Vec3d& x) { return x.length() - 0.5; }

/// A ball's distances within a narrow band.
Target ballTarget(double voxel, double width) {
  openvdb::FloatGrid::Ptr phi = test_fields::bandGrid(ball, voxel, width, width);
  return makeTarget(phi, BBoxd(Vec3d(-0.5), Vec3d(0.5)));
}

TEST(KnownDistance, NeedsNoNodeWithoutWeight) {
  openvdb::FloatTree tree(9.0f);
  for (int n = 0; n < 4; ++n) tree.setValueOn(Coord(n & 1, n >> 1, 0), static_cast<float>(1 + (n & 1) + 4 * (n >> 1)));
  const BandAccessor band(tree);
  EXPECT_EQ(knownDistance(band, Vec3d(0, 0, 0)), 1);
  EXPECT_EQ(knownDistance(band, Vec3d(1, 1, 0)), 6) << "a corner, of which no cell is known whole";
  EXPECT_EQ(knownDistance(band, Vec3d(1, 0.5, 0)), 4) << "an edge of the known cell";
  EXPECT_EQ(knownDistance(band, Vec3d(0.5, 0.5, 0)), 3.5) << "a plane through nodes";
  EXPECT_EQ(knownDistance(band, Vec3d(1, 1 - 1e-9, 1e-9)), 6) << "but for rounding";
  EXPECT_FALSE(knownDistance(band, Vec3d(0.5, 0.5, 0.01)));
  EXPECT_FALSE(knownDistance(band, Vec3d(1.01, 1, 0)));
  EXPECT_FALSE(knownDistance(band, Vec3d(-0.01, 0, 0)));
}

TEST(WideDistance, IsTheBandsOwnValueWhereverTheBandHasOne) {
  Monitor monitor;
  const double voxel = 1.0 / 32;
  const Target target = ballTarget(voxel, 3 * voxel);
  const WideDistance distance(target, BBoxd(Vec3d(-2), Vec3d(2)), monitor);
  std::vector<Vec3d> points;
  std::vector<double> expected;
  for (auto value = target.phi->cbeginValueOn(); value; ++value) {
    points.push_back(target.phi->indexToWorld(value.getCoord()));
    expected.push_back(*value);
  }
  ASSERT_GT(points.size(), 5000u);
  std::vector<double> found(points.size());
  distance.sample(points, found);
  for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(found[i], expected[i]) << points[i];
}

TEST(WideDistance, IsNearTheDistanceEverywhere) {
  Monitor monitor;
  const double voxel = 1.0 / 32;
  const WideDistance distance(ballTarget(voxel, 3 * voxel), BBoxd(Vec3d(-2), Vec3d(2)), monitor);
  std::vector<Vec3d> points;
  for (int i = 0; i < 1000; ++i) {
    const auto at = [i](double step) { return 4 * (std::fmod(i * step, 1.0) - 0.5); };
    points.push_back({at(0.6180339887), at(0.4142135624), at(0.7320508076)});
  }
  std::vector<double> found(points.size());
  distance.sample(points, found);
  for (std::size_t i = 0; i < points.size(); ++i)
    ASSERT_NEAR(found[i], ball(points[i]), std::max(voxel, 0.15 * std::abs(ball(points[i])))) << points[i];
}

}  // namespace
