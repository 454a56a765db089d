// SPDX-License-Identifier: Apache-2.0
// The largest inscribed ball of meshes: no other scores better, and lattices leave no trace.
#include "vdbtools/target/target_survey.h"

#include "search/surface_search.h"
#include "support/test_meshes.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/distance/mesh_to_sdf.h"

#include <openvdb/tools/Interpolation.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using namespace test_meshes;
using openvdb::FloatGrid;

/// A ring whose thickness changes by this much: its deepest points are a curve on which the depth rises slowly.
Mesh makeRing(double change) {
  constexpr int kAlong = 90, kAround = 30;
  Mesh mesh;
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      const double a = 2 * kPi * i / kAlong, b = 2 * kPi * j / kAround, thick = 0.12 + change * std::sin(a + 1);
      const double out = 0.38 + thick * std::cos(b);
      mesh.points.emplace_back(out * std::cos(a), out * std::sin(a), thick * std::sin(b));
    }
  const auto index = [](int i, int j) { return static_cast<std::uint32_t>(i % kAlong * kAround + j % kAround); };
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j), index(i + 1, j + 1));
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j + 1), index(i, j + 1));
    }
  return mesh;
}

FloatGrid::Ptr distancesOf(const Mesh& mesh, double voxel) {
  openvdb::initialize();
  Monitor monitor;
  return meshToSdf(
      mesh, {.voxelSize = voxel, .exteriorBandWidth = 4, .interiorBandWidth = std::numeric_limits<double>::infinity()},
      monitor);
}

struct Shape {
  const char* name;
  Mesh mesh;
  Vec3d preferred;
};

/// What the header says that the ball maximises.
double scoreOf(const InscribedBall& ball, const Vec3d& preferred) {
  const Vec3d way = ball.centre - preferred;
  return ball.radius - 0.03 * way.length() + 0.01 * way.dot(Vec3d(0.8, 0.48, 0.36));
}

std::vector<Shape> shapes() {
  return {
      {"horn", makeRing(0.004), Vec3d(0.01, 0, 0)},
      {"box", makeBox(Vec3d(-0.5, -0.2, -0.11), Vec3d(0.4, 0.22, 0.1)), Vec3d(0.7, 0.02, 0.3)},
      {"torus", makeRing(0), Vec3d(0)},
      {"ball", makeSphere(0.4, 4, Vec3d(0.013, 0.21, -0.007)), Vec3d(0)},
      {"two balls", merged(makeSphere(0.2, 3, Vec3d(-0.3, 0, 0)), makeSphere(0.2003, 3, Vec3d(0.3, 0, 0))), Vec3d(0)}};
}

TEST(InscribedBallOfAMesh, NoOtherBallScoresBetter) {
  constexpr double kVoxel = 1.0 / 60;
  for (const Shape& shape : shapes()) {
    const FloatGrid::Ptr phi = distancesOf(shape.mesh, kVoxel);
    const InscribedBall found = largestInscribedBall(*phi, shape.preferred, &shape.mesh);
    const SurfaceSearch search(shape.mesh.points, shape.mesh.triangles);
    const auto scoreAt = [&](const Vec3d& x) { return scoreOf({x, search.nearest(x)->distance}, shape.preferred); };
    EXPECT_NEAR(search.nearest(found.centre)->distance, found.radius, 1e-6) << shape.name;
    const double best = scoreAt(found.centre);
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    // From every node inside, and about what is found, ever nearer: a search that only accepts what is better.
    int tried = 0;
    for (auto value = phi->cbeginValueOn(); value; ++value) {
      if (!(*value < 0) || ++tried % 97 != 0) continue;
      Vec3d at = phi->indexToWorld(value.getCoord());
      double here = scoreAt(at), step = 2 * kVoxel;
      for (int i = 0; i < 60; ++i, step *= 0.93) {
        const Vec3d next = at + Vec3d(normal(random), normal(random), normal(random)) * step;
        if (openvdb::tools::BoxSampler::sample(phi->tree(), phi->worldToIndex(next)) > 0) continue;
        if (const double there = scoreAt(next); there > here) at = next, here = there;
      }
      ASSERT_LE(here, best + 1e-3 * kVoxel) << shape.name << at << found.centre;
    }
  }
}

TEST(InscribedBallOfAMesh, LatticesLeaveNoTrace) {
  for (const Shape& shape : shapes()) {
    const auto ballAt = [&](double voxel) {
      return largestInscribedBall(*distancesOf(shape.mesh, voxel), shape.preferred, &shape.mesh);
    };
    const InscribedBall reference = ballAt(1.0 / 97);
    for (const double voxel : {1.0 / 40, 1.0 / 64, 1.0 / 75}) {
      const InscribedBall ball = ballAt(voxel);
      EXPECT_NEAR(scoreOf(ball, shape.preferred), scoreOf(reference, shape.preferred), 1e-3 * voxel)
          << shape.name << voxel;
      // In the box and the torus many balls have one size and nearly one score: along the torus it falls by
      // 0.01 R (1 - cos a) after the angle a.
      const std::string name = shape.name;
      const double near = name == "torus" ? 2 * voxel : 0.01 * voxel;
      if (name != "box") {
        EXPECT_NEAR((ball.centre - reference.centre).length(), 0, near) << shape.name << voxel;
      }
    }
  }
}

// The wall of the smaller box is no surface of the union, and the ball passes through it.
TEST(InscribedBallOfAMesh, TouchesOnlyWhatBoundsTheShape) {
  const Mesh united = merged(makeBox(Vec3d(-0.4), Vec3d(0.4)), makeBox(Vec3d(0.1, -0.1, -0.1), Vec3d(0.7, 0.1, 0.1)));
  openvdb::initialize();
  Monitor monitor;
  vdbtools::PartCounts parts;
  const auto phi = meshToSdf(
      united,
      {.voxelSize = 1.0 / 50, .exteriorBandWidth = 4, .interiorBandWidth = std::numeric_limits<double>::infinity()},
      monitor, &parts);
  ASSERT_EQ(parts.intersecting, 2u);
  const InscribedBall found = largestInscribedBall(*phi, Vec3d(0), &united);
  EXPECT_NEAR(found.radius, 0.4, 1e-3);
  EXPECT_NEAR(found.centre.length(), 0, 1e-2);
}

}  // namespace
