// SPDX-License-Identifier: Apache-2.0
// The largest inscribed ball and the local thickness, against shapes whose values are known and against all balls.
#include "vdbtools/exponent/local_thickness.h"

#include "support/test_fields.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/target/target_survey.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr double kThicknessVoxel = 0.02;

/// The distance to balls that may overlap: exact outside of where they do, and good enough inside.
test_fields::Distance balls(std::vector<std::pair<Vec3d, double>> all) {
  return [all](const Vec3d& x) {
    double least = 1e9;
    for (const auto& [centre, radius] : all) least = std::min(least, (x - centre).length() - radius);
    return least;
  };
}

FloatGrid::Ptr gridOf(const test_fields::Distance& distance) {
  openvdb::initialize();
  return test_fields::bandGrid(distance, kThicknessVoxel, 4 * kThicknessVoxel);
}

TEST(InscribedBall, IsThatOfABallWhereverItLiesOnTheLattice) {
  for (const Vec3d& shift : {Vec3d(0), Vec3d(0.003, 0.011, -0.007), Vec3d(0.0099, -0.0099, 0.005)}) {
    const InscribedBall ball = largestInscribedBall(*gridOf(balls({{shift, 0.3}})), Vec3d(0));
    EXPECT_NEAR((ball.centre - shift).length(), 0, 0.1 * kThicknessVoxel);
    EXPECT_NEAR(ball.radius, 0.3, 0.05 * kThicknessVoxel);
  }
}

// Promise of design.md: `auto` takes the deepest place, "does not jump along parts of constant thickness, and among
//   nearly equal balls it is the nearest"
TEST(InscribedBall, TheDeepestPartWinsAndAmongEqualsTheNearest) {
  const Vec3d left(-0.3, 0, 0), right(0.3, 0, 0);
  const auto unequal = gridOf(balls({{left, 0.2}, {right, 0.25}}));
  for (const double x : {-0.3, 0.0, 0.3})
    EXPECT_NEAR((largestInscribedBall(*unequal, Vec3d(x, 0, 0)).centre - right).length(), 0, 0.1 * kThicknessVoxel)
        << x;
  const auto equal = gridOf(balls({{left, 0.2}, {right, 0.2}}));
  EXPECT_NEAR((largestInscribedBall(*equal, Vec3d(-0.1, 0, 0)).centre - left).length(), 0, 0.1 * kThicknessVoxel);
  EXPECT_NEAR((largestInscribedBall(*equal, Vec3d(0.1, 0, 0)).centre - right).length(), 0, 0.1 * kThicknessVoxel);
}

// Promise: `auto` takes the deepest ...
TEST(InscribedBall, MovesSmoothlyAlongARod) {
  const auto rod = gridOf([](const Vec3d& x) {
    const Vec3d end(std::clamp(x[0], -0.5, 0.5), 0, 0);
    return (x - end).length() - 0.1;
  });
  for (double x = -0.4; x <= 0.4; x += 0.05)
    EXPECT_NEAR(largestInscribedBall(*rod, Vec3d(x, 0.01, 0)).centre[0], x, 2 * kThicknessVoxel) << x;
}

TEST(InscribedBall, RefusesAFieldWithoutAnInside) {
  EXPECT_THROW(largestInscribedBall(*gridOf([](const Vec3d&) { return 0.01; }), Vec3d(0)), DataError);
  Monitor monitor;
  EXPECT_THROW(localThickness(*gridOf([](const Vec3d&) { return 0.01; }), monitor), DataError);
}

// Promise of design.md: tau is "the radius of the largest ball that fits in the target and holds x"
TEST(LocalThickness, OfABallIsItsRadiusAnywhere) {
  Monitor monitor;
  for (const double radius : {0.1, 0.3}) {
    const auto phi = gridOf(balls({{Vec3d(0.004, 0.002, 0.007), radius}}));
    const LocalThickness thickness = localThickness(*phi, monitor);
    EXPECT_NEAR(thickness.least, radius, 0.5 * kThicknessVoxel);
    EXPECT_NEAR(thickness.greatest, radius, 0.5 * kThicknessVoxel);
  }
}

TEST(LocalThickness, NoPartOfABoxIsThickerThanTheBallThatFits) {
  Monitor monitor;
  // Plates and rods with sharp edges, turned and moved off the nodes: behind an edge slopes of the distance mislead.
  for (const double angle : {0.0, 0.3, 0.7})
    for (const double half : {0.02, 0.03, 0.05, 0.1})
      for (const Vec3d& sides : {Vec3d(0.4, half, 0.4), Vec3d(0.4, half, half)}) {
        const double c = std::cos(angle), s = std::sin(angle);
        const auto box = gridOf([&](const Vec3d& x) {
          const Vec3d at(c * x[0] - s * x[1] + 0.004, s * x[0] + c * x[1] - 0.007, x[2] + 0.003);
          const Vec3d beyond(std::abs(at[0]) - sides[0], std::abs(at[1]) - sides[1], std::abs(at[2]) - sides[2]);
          const Vec3d outside(std::max(beyond[0], 0.0), std::max(beyond[1], 0.0), std::max(beyond[2], 0.0));
          return outside.length() + std::min(0.0, std::max({beyond[0], beyond[1], beyond[2]}));
        });
        EXPECT_LE(localThickness(*box, monitor).greatest, half + 0.05 * kThicknessVoxel)
            << angle << ' ' << half << ' ' << sides;
      }
}

// Promise: tau is "the radius of the largest ..."
TEST(LocalThickness, OfAWallIsHalfItsWidth) {
  Monitor monitor;
  for (const double half : {0.013, 0.02, 0.05, 0.1}) {
    const auto wall = gridOf([half](const Vec3d& x) {
      const Vec3d beyond(std::max(0.0, std::abs(x[0]) - 0.4), std::max(0.0, std::abs(x[1]) - 0.4), 0);
      const double out = beyond.length();
      const double through = std::abs(x[2] - 0.003) - half;
      return out > 0 ? std::hypot(out, std::max(0.0, through)) : through;
    });
    const Control tau = thicknessControl(localThickness(*wall, monitor));
    for (const double z : {0.0, 0.4 * half, 0.8 * half})
      EXPECT_NEAR(tau.at(Vec3d(0.05, -0.1, 0.003 + z)), half, 0.5 * kThicknessVoxel) << half << ' ' << z;
  }
}

// Promise: tau is "the radius of the largest ..."
TEST(LocalThickness, IsThatOfAllBallsInTheShapeUpToTheSlope) {
  Monitor monitor;
  const auto phi = gridOf(test_fields::lumpy);
  const LocalThickness thickness = localThickness(*phi, monitor);
  // Every ball about a node that fits.
  std::vector<std::pair<Vec3d, double>> all;
  for (auto value = phi->cbeginValueOn(); value; ++value)
    if (*value < 0) all.emplace_back(phi->indexToWorld(value.getCoord()), -*value);
  std::mt19937 random(1);
  int compared = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3d node = all[random() % all.size()].first;
    double brute = 0;
    for (const auto& [centre, radius] : all)
      if ((node - centre).length() <= radius + 1.37 * kThicknessVoxel) brute = std::max(brute, radius);
    const double tau = thickness.tau->tree().getValue(Coord::round(thickness.tau->worldToIndex(node)));
    // It is limited in slope, and so may be less; it is more by what the ridge between the nodes adds, at most half a
    // cell's diagonal, and a ball holds the nodes within half a voxel of it.
    EXPECT_LE(tau, brute + kThicknessVoxel);
    EXPECT_GE(tau, thickness.least);
    compared += std::abs(tau - brute) < kThicknessVoxel;
  }
  EXPECT_GT(compared, 100);
}

// Promise: "D tau grows with D everywhere", and for D ...
TEST(LocalThickness, NeverRisesFasterThanItsSlope) {
  Monitor monitor;
  const auto phi = gridOf(balls({{Vec3d(-0.3, 0, 0), 0.25}, {Vec3d(0.1, 0, 0), 0.06}, {Vec3d(0.2, 0, 0), 0.06}}));
  const LocalThickness thickness = localThickness(*phi, monitor);
  const auto accessor = thickness.tau->getConstAccessor();
  for (auto value = thickness.tau->cbeginValueOn(); value; ++value)
    for (int axis = 0; axis < 3; ++axis) {
      Coord next = value.getCoord();
      ++next[axis];
      if (!accessor.isValueOn(next)) continue;
      ASSERT_LE(std::abs(accessor.getValue(next) - *value), kThicknessSlope * kThicknessVoxel * 1.0001)
          << value.getCoord();
    }
}

TEST(LocalThickness, AThinPartThatHoldsNoNodeCountsAsThin) {
  Monitor monitor;
  // A disc between two layers of nodes, beside a ball.
  const auto distance = [](const Vec3d& x) {
    const double disc = std::max(std::abs(x[2] - 0.01) - 0.004, std::hypot(x[0] - 0.6, x[1]) - 0.25);
    return std::min(disc, (x - Vec3d(0)).length() - 0.3);
  };
  const LocalThickness thickness = localThickness(*gridOf(distance), monitor);
  EXPECT_NEAR(thicknessControl(thickness).at(Vec3d(0.7, 0, 0.01)), kLeastThickness * kThicknessVoxel,
              0.3 * kThicknessVoxel);
}

TEST(InsideVolume, OfABall) {
  const double exact = 4.0 / 3 * 3.14159265358979 * 0.3 * 0.3 * 0.3;
  const auto whole = gridOf(balls({{Vec3d(0.001, 0.004, 0), 0.3}}));
  EXPECT_NEAR(insideVolume(*whole) / exact, 1, 2e-3);
  const auto band =
      test_fields::bandGrid(balls({{Vec3d(0), 0.3}}), kThicknessVoxel, 3 * kThicknessVoxel, 3 * kThicknessVoxel);
  EXPECT_NEAR(insideVolume(*band) / exact, 1, 2e-3);
}

}  // namespace
