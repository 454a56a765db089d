// SPDX-License-Identifier: Apache-2.0
// Bands of distances: what is in them, and their signs beside those of OpenVDB's meshToVolume.
#include "distance/distance_band.h"
#include "support/test_meshes.h"

#include <gtest/gtest.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace {

using namespace test_meshes;
using openvdb::Coord;
using openvdb::FloatGrid;
using vdbtools::BlockDistances;
using vdbtools::Monitor;
using vdbtools::Phase;
using vdbtools::PhaseKind;
using vdbtools::signedDistances;
using vdbtools::TriangleTree;
using vdbtools::unsignedDistances;

class DistanceBand : public testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }
  Monitor monitor;
};

/// By the library's own instantiation, which reads points in single precision.
FloatGrid::Ptr byOpenVdb(const Mesh& mesh, float band) {
  const std::vector<openvdb::Vec3s> points(mesh.points.begin(), mesh.points.end());
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, Vec3I> adapter(points, mesh.triangles);
  return openvdb::tools::meshToVolume<FloatGrid>(adapter, *openvdb::math::Transform::createLinearTransform(1.0), band,
                                                 band);
}

TEST_F(DistanceBand, HoldsAllNodesWithinItsWidth) {
  const Mesh mesh = merged(makeSphere(13, 4, Vec3d(0.2, 0.1, 0.4)), makeBox(Vec3d(30.5, -3, -4), Vec3d(50, 5, 40.2)));
  const TriangleTree tree(mesh.points, mesh.triangles);
  for (const float width : {1.5F, 7.0F, 40.0F}) {
    const FloatGrid::Ptr grid = unsignedDistances(tree, width, PhaseKind::DistanceField, monitor);
    BlockDistances all(tree);
    const auto accessor = grid->getConstAccessor();
    std::uint64_t within = 0;
    for (int x = -64; x < 112; x += 8)
      for (int y = -64; y < 64; y += 8)
        for (int z = -64; z < 88; z += 8) {
          all.evaluate(Coord(x, y, z), 1e9F);
          for (int n = 0; n < 512; ++n) {
            const Coord node(x + (n >> 6), y + (n >> 3 & 7), z + (n & 7));
            const float d = all.distances()[n];
            ASSERT_EQ(accessor.isValueOn(node), d < width) << node;
            ASSERT_EQ(accessor.getValue(node), std::min(d, width)) << node;
            within += d < width;
          }
        }
    EXPECT_EQ(grid->activeVoxelCount(), within) << "all of the band lies in the box that was looked at";
  }
}

// Promise of design.md: "Signs are those of `tools::meshToVolume`"
TEST_F(DistanceBand, SidesAreThoseOfMeshToVolume) {
  const Mesh meshes[] = {makeSphere(15, 4, Vec3d(0.2, 0.1, 0.4)),
                         makeBox(Vec3d(-12.3, -9.1, -20.7), Vec3d(11.9, 10.4, 3.2)),
                         flipped(makeSphere(9, 3)),
                         makeSoup(makeSphere(12, 3), 0),
                         merged(makeSphere(14, 4), flipped(makeSphere(8, 4))),
                         merged(makeSphere(10, 4), makeSphere(10, 4, Vec3d(30.2, 0, 0))),
                         withoutTriangles(makeSphere(10, 3), [](const Vec3d& c) { return c[2] > 9.5; })};
  for (const Mesh& mesh : meshes) {
    constexpr float kWidth = 4;
    const FloatGrid::Ptr ours =
        signedDistances(TriangleTree(mesh.points, mesh.triangles), kWidth, kWidth, PhaseKind::DistanceField, monitor);
    const FloatGrid::Ptr theirs = byOpenVdb(mesh, kWidth);
    const auto accessor = ours->getConstAccessor();
    int different = 0;
    for (auto value = theirs->cbeginValueOn(); value; ++value) {
      // Beside the surface, a rounding decides.
      if (std::abs(*value) < 0.01F) continue;
      different += (*value < 0) != (accessor.getValue(value.getCoord()) < 0);
    }
    EXPECT_EQ(different, 0) << mesh.triangles.size() << " triangles";
    EXPECT_GT(theirs->activeVoxelCount(), 1000U);
  }
}

TEST_F(DistanceBand, TheWholeInsideIsKnown) {
  const Mesh mesh = makeSphere(40, 5);
  const FloatGrid::Ptr grid =
      signedDistances(TriangleTree(mesh.points, mesh.triangles), 2, 60, PhaseKind::DistanceField, monitor);
  const auto accessor = grid->getConstAccessor();
  for (int x = -38; x <= 38; x += 2)
    for (int z = -38; z <= 38; z += 2) {
      const double r = std::hypot(x, 3, z);
      if (r > 39) continue;
      ASSERT_TRUE(accessor.isValueOn(Coord(x, 3, z)));
      ASSERT_NEAR(accessor.getValue(Coord(x, 3, z)), r - 40, 0.06);  // faces lie within the sphere
    }
  EXPECT_EQ(accessor.getValue(Coord(200, 0, 0)), 2);
  EXPECT_FALSE(accessor.isValueOn(Coord(43, 0, 0)));
}

/// What lies in another solid bounds nothing.
// Promise: "Signs are those of `tools::meshToVolume`"
TEST_F(DistanceBand, BuriedTrianglesAreLeftOut) {
  const Mesh outer = makeSphere(30, 5), both = merged(outer, makeSphere(10, 4, Vec3d(5, 0, 0)));
  const FloatGrid::Ptr whole =
      signedDistances(TriangleTree(outer.points, outer.triangles), 3, 40, PhaseKind::DistanceField, monitor);
  const FloatGrid::Ptr buried =
      signedDistances(TriangleTree(both.points, both.triangles), 3, 40, PhaseKind::DistanceField, monitor);
  ASSERT_EQ(whole->activeVoxelCount(), buried->activeVoxelCount());
  const auto accessor = buried->getConstAccessor();
  for (auto value = whole->cbeginValueOn(); value; ++value)
    ASSERT_NEAR(accessor.getValue(value.getCoord()), *value, 1e-5) << value.getCoord();
}

TEST_F(DistanceBand, ThreadsChangeNothing) {
  const Mesh mesh = makeSoup(makeSphere(25, 4), 0.2);
  const TriangleTree tree(mesh.points, mesh.triangles);
  FloatGrid::Ptr first;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const FloatGrid::Ptr grid = signedDistances(tree, 5, 9, PhaseKind::DistanceField, monitor);
    if (!first) first = grid;
    ASSERT_EQ(grid->activeVoxelCount(), first->activeVoxelCount());
    const auto accessor = grid->getConstAccessor();
    for (auto value = first->cbeginValueAll(); value; ++value) ASSERT_EQ(accessor.getValue(value.getCoord()), *value);
  }
}

TEST_F(DistanceBand, TellsItsShareAndStopsWhenAsked) {
  struct Counting : Monitor {
    void begin(const Phase&, std::uint64_t n) override { total = n; }
    void advance(std::uint64_t n) override { done += n; }
    std::atomic<std::uint64_t> total = 0, done = 0;
  } counting;
  const Mesh mesh = makeSphere(60, 3);
  const TriangleTree tree(mesh.points, mesh.triangles);
  unsignedDistances(tree, 5, PhaseKind::DistanceField, counting);
  EXPECT_GT(counting.total, 8U);
  EXPECT_EQ(counting.done, counting.total);
  struct Cancelled : Monitor {
    bool cancelled() const override { return true; }
  } cancelled;
  EXPECT_THROW(signedDistances(tree, 5, 5, PhaseKind::DistanceField, cancelled), vdbtools::Interrupted);
}

}  // namespace
