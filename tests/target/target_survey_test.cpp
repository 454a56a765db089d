// SPDX-License-Identifier: Apache-2.0
// The volume of a target, and of the part of it in a box.
#include "vdbtools/target/target_survey.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Vec3d;

constexpr float kBallRadius = 1, kBallVoxel = 0.04f;
const Vec3d kBallCentre(0.3, -0.2, 5);

openvdb::FloatGrid::Ptr surveyedBall() {
  openvdb::initialize();
  return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(kBallRadius, openvdb::Vec3f(kBallCentre), kBallVoxel);
}

// Promise: With `--box` the share that is left ...
TEST(TargetSurvey, TheVolumeInABoxIsThatOfThePartThere) {
  const auto phi = surveyedBall();
  const double whole = insideVolume(*phi), far = 10;
  EXPECT_NEAR(whole, 4 * M_PI / 3, 0.01);
  const BBoxd all(kBallCentre - Vec3d(far), kBallCentre + Vec3d(far));
  EXPECT_NEAR(insideVolume(*phi, all), whole, 1e-9);
  EXPECT_EQ(insideVolume(*phi, BBoxd(kBallCentre + Vec3d(2), kBallCentre + Vec3d(3))), 0);
  // A box within the ball is full, whatever part of a voxel its sides cut off.
  const BBoxd inner(kBallCentre - Vec3d(0.31, 0.27, 0.123), kBallCentre + Vec3d(0.3, 0.333, 0.4));
  EXPECT_NEAR(insideVolume(*phi, inner), inner.volume(), 1e-6);
  // A cap of height h of a ball has the volume pi h^2 (r - h / 3).
  for (int axis = 0; axis < 3; ++axis) {
    const double height = 0.37;
    BBoxd cap = all, rest = all;
    cap.min()[axis] = rest.max()[axis] = kBallCentre[axis] + kBallRadius - height;
    EXPECT_NEAR(insideVolume(*phi, cap), M_PI * height * height * (kBallRadius - height / 3), 0.005);
    EXPECT_NEAR(insideVolume(*phi, cap) + insideVolume(*phi, rest), whole, 1e-9);
  }
}

}  // namespace
