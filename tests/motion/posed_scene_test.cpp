// SPDX-License-Identifier: Apache-2.0
// Fractals of a target that moves: F'(x) = F(rho(x)).
#include "vdbtools/job/fractal_job.h"

#include "support/moving_tubes.h"
#include "support/test_meshes.h"

#include "vdbtools/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Mat3d;
using openvdb::Vec3d;

using MeshPtr = std::shared_ptr<const Mesh>;

MeshPtr restingTube() {
  static const MeshPtr tube = std::make_shared<const Mesh>(moving_tubes::straightTube());
  return tube;
}

/// @param pose  nullptr: the tube at rest
FractalOptions tubeOptions(const MeshPtr& pose, Recipe recipe) {
  openvdb::initialize();
  recipe.insert({{"input", "memory"}, {"sdf-resolution", "60"}, {"resolution", "50"}});
  FractalOptions options = parseFractalOptions(completeRecipe(recipe, fractalOptionTable()));
  options.target->mesh = pose ? pose : restingTube();
  if (pose) options.rest = RestOptions{.file = NamedFile{"rest", "rest-sha256", ""}, .mesh = restingTube()};
  return options;
}

class PosedScene : public testing::Test {
 protected:
  Scene posed(const Mesh& pose, const Recipe& recipe = {}) {
    return mMaker.make(tubeOptions(std::make_shared<const Mesh>(pose), recipe), mMonitor);
  }
  Scene still() { return mMaker.make(tubeOptions(nullptr, {}), mMonitor); }

  Monitor mMonitor;
  SceneMaker mMaker;  ///< makes what belongs to the tube at rest once
};

std::vector<double> fieldAt(const Scene& scene, const std::vector<Vec3d>& world) {
  std::vector<julia::Point> points;
  for (const Vec3d& x : world) points.push_back(scene.field.space.toFractal(x));
  std::vector<double> field(points.size());
  scene.field.evaluator->evaluate(points, field, {});
  return field;
}

// Promise: "a vertex that is brought ..."
TEST_F(PosedScene, ATurnedTargetHasTheSameSetBesideItsSurface) {
  const Mesh& rest = *restingTube();
  const Mat3d turn = openvdb::math::rotation<Mat3d>(Vec3d(1, 2, 0.5).unit(), 0.9);
  const Vec3d by(0.37, -1.2, 5.1);
  Mesh pose = rest;
  for (Vec3d& p : pose.points) p = turn * p + by;
  const Scene atRest = still(), inPose = posed(pose);
  std::mt19937 random(2);
  const auto unit = [&] { return random() / 4294967295.0; };
  std::vector<Vec3d> places, moved;
  for (int i = 0; i < 20000; ++i) {
    const double angle = 6.2832 * unit(), radius = 0.3 + 0.25 * unit();
    places.emplace_back(4 * unit(), radius * std::cos(angle), radius * std::sin(angle));
    moved.push_back(turn * places.back() + by);
  }
  const std::vector<double> before = fieldAt(atRest, places), after = fieldAt(inPose, moved);
  int inside = 0, differ = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    inside += before[i] < 0;
    differ += (before[i] < 0) != (after[i] < 0);
  }
  EXPECT_GT(inside, 5000);
  EXPECT_LT(inside, 15000);
  // Only points that lie on the surface up to rounding may change sides.
  EXPECT_LE(differ, 20);
}

// Promise of motion.md: "a vertex that is brought back lies on the surface at rest within the tolerance of its search"
TEST_F(PosedScene, VerticesBroughtBackLieOnTheSurfaceAtRest) {
  const Mesh pose = moving_tubes::bent(*restingTube(), 90);
  const Scene atRest = still(), inPose = posed(pose);
  const Mesh mesh = fractalMesh(inPose, mMonitor);
  ASSERT_GT(mesh.points.size(), 1000u);
  const std::vector<Vec3d> back = inPose.atRest(mesh.points);
  // Each vertex lies within the tolerance of a change of sign.
  const double step = 0.03 * inPose.voxelSize;
  std::vector<Vec3d> around;
  for (const Vec3d& x : back)
    for (int k = 0; k < 6; ++k) {
      Vec3d by(0);
      by[k / 2] = k % 2 ? step : -step;
      around.push_back(x + by);
    }
  const std::vector<double> field = fieldAt(atRest, around);
  std::size_t on = 0;
  for (std::size_t i = 0; i < back.size(); ++i) {
    int inside = 0;
    for (std::size_t k = 0; k < 6; ++k) inside += field[6 * i + k] < 0;
    on += inside > 0 && inside < 6;
  }
  EXPECT_GT(static_cast<double>(on), 0.98 * static_cast<double>(back.size()));
}

// Promise: "no node is skipped that would ..."
TEST_F(PosedScene, ProofsHoldAtEveryPointOfTheirBalls) {
  const Mesh pose = moving_tubes::bent(*restingTube(), 150, 1.6, 2.6);
  const Scene inPose = posed(pose);
  ASSERT_GT(inPose.rest.value().jumps, 0);
  std::mt19937 random(4);
  const auto unit = [&] { return random() / 4294967295.0; };
  const openvdb::BBoxd box = inPose.target->distances.box;
  std::vector<julia::Point> centres;
  for (int i = 0; i < 4000; ++i) {
    const Vec3d part(unit() * 1.2 - 0.1, unit() * 1.2 - 0.1, unit() * 1.2 - 0.1);
    centres.push_back(inPose.field.space.toFractal(box.min() + part * box.extents()));
  }
  int decided[3] = {};
  for (const double radius : {0.002, 0.01, 0.05}) {
    std::vector<julia::Decision> decisions(centres.size());
    inPose.field.evaluator->decide(centres, radius, decisions);
    for (std::size_t i = 0; i < centres.size(); ++i) {
      ++decided[static_cast<int>(decisions[i])];
      if (decisions[i] == julia::Decision::Undecided) continue;
      std::vector<julia::Point> points;
      for (int k = 0; k < 20; ++k) {
        const Vec3d way = Vec3d(unit() - 0.5, unit() - 0.5, unit() - 0.5).unit() * (radius * 0.999 * unit());
        points.push_back({centres[i][0] + way[0], centres[i][1] + way[1], centres[i][2] + way[2]});
      }
      std::vector<double> field(points.size());
      inPose.field.evaluator->evaluate(points, field, {});
      for (const double value : field) ASSERT_EQ(value < 0, decisions[i] == julia::Decision::Inside);
    }
  }
  EXPECT_GT(decided[1], 20);
  EXPECT_GT(decided[2], 1000);
}

// Promise: "no node is skipped that would ..."
TEST_F(PosedScene, SkippedIsExhaustiveWhereTheSurfaceFoldsAndCoversItself) {
  const Mesh& rest = *restingTube();
  // An end within the other half, and a sharp fold.
  for (const Mesh& pose : {moving_tubes::bent(rest, 150, 1.6, 2.6), moving_tubes::bent(rest, 350, 1, 3)}) {
    const Mesh fast = fractalMesh(posed(pose, {{"resolution", "30"}}), mMonitor);
    const Mesh slow = fractalMesh(posed(pose, {{"resolution", "30"}, {"exhaustive", "true"}}), mMonitor);
    EXPECT_GT(fast.triangles.size(), 500u);
    EXPECT_EQ(fast.points, slow.points);
    EXPECT_EQ(fast.triangles, slow.triangles);
    const MeshReport report = reportMesh(fast);
    EXPECT_TRUE(report.closed());
  }
}

TEST_F(PosedScene, ScenesOfASequenceDoNotDependOnThoseBefore) {
  const Mesh& rest = *restingTube();
  posed(moving_tubes::bent(rest, 20));
  const auto pose = std::make_shared<const Mesh>(moving_tubes::bent(rest, 80));
  const Scene after = mMaker.make(tubeOptions(pose, {}), mMonitor);
  const Scene alone = makeScene(tubeOptions(pose, {}), mMonitor);
  EXPECT_EQ(fractalMesh(after, mMonitor).points, fractalMesh(alone, mMonitor).points);
  EXPECT_EQ(after.metadata, alone.metadata);
  EXPECT_EQ(after.voxelSize, alone.voxelSize);
}

}  // namespace
