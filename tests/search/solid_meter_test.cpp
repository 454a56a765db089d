// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/search/solid_meter.h"

#include "support/test_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace {

using namespace vdbtools;
using namespace test_meshes;

TEST(SolidMeter, MeasuresPartsAndTakesCavitiesOff) {
  const Mesh hollow = merged(makeCube(3, Vec3d(100, 5, 0)), flipped(makeCube(1, Vec3d(100, 5, 0))));
  const SolidMeasure measure = measureSolid(merged(hollow, makeCube(2, Vec3d(-7, 0, 0))));
  EXPECT_NEAR(measure.volume, 27 - 1 + 8, 1e-9);
  ASSERT_EQ(measure.islands.size(), 2u);
  EXPECT_NEAR(measure.islands[0], 27, 1e-9);
  EXPECT_NEAR(measure.islands[1], 8, 1e-9);
  EXPECT_NEAR(measure.shareOfLargest(1), 27.0 / 35, 1e-12);
  EXPECT_EQ(measure.shareOfLargest(9), 1);
}

TEST(SolidMeter, NothingHoldsNothing) {
  const SolidMeasure measure = SolidMeter().measure();
  EXPECT_EQ(measure.volume, 0);
  EXPECT_TRUE(measure.islands.empty());
  EXPECT_EQ(measure.shareOfLargest(1), 0);
}

TEST(SolidMeter, PiecesAddUpToTheWhole) {
  // Points and triangles of two spheres in the order of their points, as a stream has them, with old points let go.
  const Mesh mesh = merged(makeSphere(1, 3), makeSphere(0.5, 2, Vec3d(3, 0, 0)));
  Mesh passed;
  MeshCollector collector(passed);
  SolidMeter meter(&collector);
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto last = [&](std::size_t i) {
    const openvdb::Vec3I& t = mesh.triangles[i];
    return std::max({t[0], t[1], t[2]});
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return last(a) < last(b); });
  // The least point that a triangle or a later one uses.
  std::vector<std::uint64_t> least(order.size() + 1, mesh.points.size());
  for (std::size_t i = order.size(); i-- > 0;) {
    const openvdb::Vec3I& t = mesh.triangles[order[i]];
    least[i] = std::min<std::uint64_t>(least[i + 1], std::min({t[0], t[1], t[2]}));
  }
  std::size_t added = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (; added <= last(order[i]); ++added) meter.addPoints({{&mesh.points[added], 1}});
    meter.addTriangles({&mesh.triangles[order[i]], 1}, least[i]);
  }
  const SolidMeasure pieces = meter.measure(), whole = measureSolid(mesh);
  ASSERT_EQ(pieces.islands.size(), 2u);
  EXPECT_NEAR(pieces.volume, whole.volume, 1e-12);
  EXPECT_NEAR(pieces.islands[0], whole.islands[0], 1e-12);
  EXPECT_NEAR(whole.volume, reportMesh(mesh).volume, 1e-9);
  EXPECT_EQ(passed.triangles.size(), mesh.triangles.size()) << "what passes is passed on";
}

}  // namespace
