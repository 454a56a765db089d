// SPDX-License-Identifier: Apache-2.0
// Motions whose truth is known.
#include "vdbtools/motion/surface_motion.h"

#include "support/moving_tubes.h"
#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace {

using namespace vdbtools;
using openvdb::Mat3d;
using openvdb::Vec3d;

double unitNumber(std::mt19937& random) { return random() / 4294967295.0; }

/// Places within and around the tube.
std::vector<Vec3d> placesAboutTube(int count, unsigned seed = 7) {
  std::mt19937 random(seed);
  std::vector<Vec3d> places;
  for (int i = 0; i < count; ++i) {
    const double x = -0.8 + 5.6 * unitNumber(random), y = -0.8 + 1.6 * unitNumber(random);
    places.emplace_back(x, y, -0.8 + 1.6 * unitNumber(random));
  }
  return places;
}

Mesh mapped(Mesh mesh, const AffineMap& map) {
  for (Vec3d& p : mesh.points) p = map(p);
  return mesh;
}

Mat3d rotation(double degrees) {
  const Vec3d axis = Vec3d(1, 2, 0.5).unit();
  const double angle = degrees * test_meshes::kPi / 180;
  return openvdb::math::rotation<Mat3d>(axis, angle);
}

/// The largest difference between rho and a map, for motions from a tube moved by the map back to the tube.
double mostOff(const AffineMap& map, MotionDepth depth = MotionDepth::Stretched) {
  const Mesh tube = moving_tubes::straightTube();
  const SurfaceMotion motion(mapped(tube, map), tube, depth);
  double most = 0;
  for (const Vec3d& x : placesAboutTube(400)) most = std::max(most, (motion.carry(map(x)).at - x).length());
  return most;
}

// Promise of motion.md: "If the whole target is turned, moved, scaled or sheared, the fractal is the same one"
TEST(SurfaceMotion, RigidMotionsSimilaritiesAndAffineMapsAreReproduced) {
  EXPECT_LT(mostOff({}), 1e-12);
  for (const double degrees : {1., 10., 90., 180.})
    EXPECT_LT(mostOff({rotation(degrees), {3, -2, 1}}), 1e-11) << degrees;
  EXPECT_LT(mostOff({rotation(40) * 1.5, {0.1, 0, 7}}), 1e-11);
  EXPECT_LT(mostOff({Mat3d(1.3, 0.2, 0., 0., 0.9, 0.1, 0.05, 0., 1.1), {1, 1, 1}}), 1e-11);
  EXPECT_LT(mostOff({Mat3d(1., 0., 0., 0., 1., 0., 0., 0., -1.), {0, 0, 0}}), 1e-11);  // a mirror
  // Far from 0, positions have fewer digits.
  EXPECT_LT(mostOff({rotation(30), {1e5, -3e5, 0}}), 1e-8);
}

TEST(SurfaceMotion, PointsOfTheSurfaceKeepTheirWeights) {
  const Mesh rest = moving_tubes::straightTube(), pose = moving_tubes::bent(rest, 90);
  const SurfaceMotion motion(pose, rest, MotionDepth::Stretched);
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const openvdb::Vec3I& t = pose.triangles[random() % pose.triangles.size()];
    double u = unitNumber(random), v = unitNumber(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const auto at = [&](const Mesh& mesh) {
      return mesh.points[t[0]] * (1 - u - v) + mesh.points[t[1]] * u + mesh.points[t[2]] * v;
    };
    EXPECT_LT((motion.carry(at(pose)).at - at(rest)).length(), 1e-12);
  }
}

TEST(SurfaceMotion, PartsThatMoveApartAreCarriedEachByItself) {
  const Mesh still = test_meshes::makeSphere(1, 3), other = test_meshes::makeSphere(0.7, 3, Vec3d(3, 0, 0));
  const AffineMap away{rotation(70), {4, 1, -2}};
  const SurfaceMotion motion(test_meshes::merged(still, mapped(other, away)), test_meshes::merged(still, other),
                             MotionDepth::Stretched);
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const double a = unitNumber(random) - 0.5, b = unitNumber(random) - 0.5, c = unitNumber(random) - 0.5;
    const Vec3d x = Vec3d(a, b, c).unit() * (0.5 + unitNumber(random));
    EXPECT_LT((motion.carry(x).at - x).length(), 1e-11);
    const Vec3d y = Vec3d(3, 0, 0) + x * 0.7;
    EXPECT_LT((motion.carry(away(y)).at - y).length(), 1e-11);
  }
}

TEST(SurfaceMotion, DepthIsStretchedOrKept) {
  const Mesh rest = test_meshes::makeSphere(1, 4), pose = test_meshes::transformed(rest, 2, Vec3d(0));
  const SurfaceMotion stretched(pose, rest, MotionDepth::Stretched), kept(pose, rest, MotionDepth::Kept);
  for (const Vec3d& direction : {Vec3d(1, 0.2, 0.1).unit(), Vec3d(-0.3, 1, 0.5).unit()}) {
    const Vec3d x = direction * 2.3;
    EXPECT_NEAR(stretched.carry(x).at.length(), 1.15, 0.002);
    EXPECT_NEAR(kept.carry(x).at.length(), 1.3, 0.004);
  }
  EXPECT_NEAR(stretched.greatestGrowth(), 2, 1e-9);
  EXPECT_NEAR(kept.greatestGrowth(), 1, 1e-9);
}

TEST(SurfaceMotion, IsContinuousAndHasItsGradientAwayFromJumps) {
  const Mesh rest = moving_tubes::straightTube(), pose = moving_tubes::bent(rest, 60);
  const SurfaceMotion motion(pose, rest, MotionDepth::Stretched);
  std::mt19937 random(11);
  int checked = 0;
  for (int i = 0; i < 300; ++i) {
    // Beside a point of the surface, much nearer to it than the axis of the tube.
    const openvdb::Vec3I& t = pose.triangles[random() % pose.triangles.size()];
    const Vec3d p = (pose.points[t[0]] + pose.points[t[1]] + pose.points[t[2]]) / 3;
    const Vec3d normal = (pose.points[t[1]] - pose.points[t[0]]).cross(pose.points[t[2]] - pose.points[t[0]]).unit();
    const Vec3d x = p + normal * (0.3 * (unitNumber(random) - 0.5));
    const SurfaceMotion::Image image = motion.carry(x);
    const Vec3d step = Vec3d(unitNumber(random), unitNumber(random), unitNumber(random)) * 1e-5;
    const Vec3d moved = motion.carry(x + step).at - image.at;
    EXPECT_LT(moved.length(), 3e-5);
    checked += (moved - image.gradient * step).length() < 0.35e-5;
    // The hint changes nothing.
    EXPECT_EQ(motion.carry(x, motion.carry(x + step).hint).at, image.at);
    EXPECT_LT((motion.carryBy(image.hint, x).at - image.at).length(), 1e-14);
  }
  EXPECT_GT(checked, 290);
}

TEST(SurfaceMotion, TrianglesWithoutAreaAndTornVerticesDoNoHarm) {
  Mesh rest = moving_tubes::straightTube();
  const AffineMap turn{rotation(25), {1, 2, 3}};
  // A soup has points of its own for each triangle; pieces without area come last.
  Mesh soup = test_meshes::makeSoup(rest, 0);
  soup.triangles.insert(soup.triangles.end(), {{0, 0, 1}, {5, 5, 5}});
  const SurfaceMotion motion(mapped(soup, turn), soup, MotionDepth::Stretched);
  for (const Vec3d& x : placesAboutTube(100)) EXPECT_LT((motion.carry(turn(x)).at - x).length(), 1e-11);

  // A ring that falls into one point in the pose.
  Mesh pose = rest;
  for (std::size_t i = 321; i < 353; ++i) pose.points[i] = pose.points[321];
  const SurfaceMotion collapsed(pose, rest, MotionDepth::Stretched);
  for (const Vec3d& x : placesAboutTube(100)) EXPECT_TRUE(collapsed.carry(x).at.isFinite());
  const SurfaceMotion opened(rest, pose, MotionDepth::Stretched);
  for (const Vec3d& x : placesAboutTube(100)) EXPECT_TRUE(opened.carry(x).at.isFinite());
}

TEST(SurfaceMotion, MeshesThatDoNotBelongTogetherAreRefused) {
  const auto why = [](const Mesh& pose, const Mesh& rest) {
    try {
      SurfaceMotion(pose, rest, MotionDepth::Stretched);
    } catch (const DataError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const Mesh tube = moving_tubes::straightTube(), sphere = test_meshes::makeSphere(1, 3);
  EXPECT_NE(why(tube, sphere).find("and the mesh at rest has 1280"), std::string::npos) << why(tube, sphere);
  Mesh shuffled = tube;
  std::reverse(shuffled.triangles.begin(), shuffled.triangles.end());
  EXPECT_NE(why(tube, shuffled).find("of the mesh at rest has other corners"), std::string::npos)
      << why(tube, shuffled);
  const Mesh large = test_meshes::transformed(tube, 1000, Vec3d(0));
  EXPECT_NE(why(tube, large).find("the mesh at rest is 1000 times as large"), std::string::npos) << why(tube, large);
  EXPECT_NE(why(large, tube).find("the mesh at rest is 1000 times as small"), std::string::npos) << why(large, tube);
  // A mirror image is an affine map, but not that of a tube that bends.
  Mesh mirrored = tube;
  for (Vec3d& p : mirrored.points) p[2] = -p[2];
  const Mesh bent = moving_tubes::bent(tube, 120);
  EXPECT_NE(why(bent, mirrored).find("the mesh at rest is turned inside out"), std::string::npos)
      << why(bent, mirrored);
  const Mesh flat = test_meshes::transformed(tube, 0, Vec3d(0));
  EXPECT_NE(why(flat, tube), "");
  EXPECT_NE(why(tube, flat), "");
  EXPECT_EQ(why(tube, tube), "");
}

}  // namespace
