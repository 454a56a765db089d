// SPDX-License-Identifier: Apache-2.0
// Velocities of surfaces whose motion is known.
#include "vdbtools/motion/surface_motion.h"

#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

constexpr double kStep = 1.0 / 24;  // seconds

using Motion = std::function<Vec3d(const Vec3d&)>;

SurfaceAt velocityMoment(const Mesh& mesh, double seconds, const Motion& motion) {
  Mesh moved = mesh;
  for (Vec3d& point : moved.points) point = motion(point);
  return {seconds, std::make_shared<const Mesh>(std::move(moved)), "the other mesh"};
}

/// Points on a mesh, and some beside it.
std::vector<Vec3d> placesAbout(const Mesh& mesh) {
  std::vector<Vec3d> places;
  for (const openvdb::Vec3I& t : mesh.triangles) {
    const Vec3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    const Vec3d at = (a + 2 * b + 3 * c) / 6, normal = (b - a).cross(c - a).unit();
    for (const double away : {0.0, 0.05, -0.1, 0.3}) places.push_back(at + away * normal);
  }
  return places;
}

/// The largest difference between velocities and those that are expected.
double greatestVelocityError(const Mesh& mesh, const std::vector<SurfaceAt>& moments, const Motion& expected,
                             MotionDepth depth = MotionDepth::Stretched) {
  const SurfaceVelocity velocity(mesh, moments, depth);
  const std::vector<Vec3d> places = placesAbout(mesh), found = velocity.at(places);
  double greatest = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    greatest = std::max(greatest, (found[i] - expected(places[i])).length());
  return greatest;
}

Vec3d turnedBy(double angle, const Vec3d& axis, const Vec3d& x) {
  return x * std::cos(angle) + axis.cross(x) * std::sin(angle) + axis * axis.dot(x) * (1 - std::cos(angle));
}

// Promise of attributes.md: "The velocity of a point is the way that it goes from the frame before to the frame after,
//   by the time between them"
TEST(Velocity, OfATranslationIsTheSameEverywhere) {
  const Vec3d step(0.3, -0.2, 0.7);
  const auto by = [&](double frames) { return [=](const Vec3d& x) { return Vec3d(x + frames * step); }; };
  const auto expected = [&](const Vec3d&) { return Vec3d(step / kStep); };
  for (const Mesh& mesh : {test_meshes::makeSphere(1, 2), test_meshes::makeCube(0.5)}) {
    const SurfaceAt before = velocityMoment(mesh, -kStep, by(-1)), after = velocityMoment(mesh, kStep, by(1));
    for (const std::vector<SurfaceAt>& moments : {std::vector{before, after}, {before}, {after}})
      EXPECT_LT(greatestVelocityError(mesh, moments, expected), 1e-10);
  }
}

// Promise: "The velocity of a point ..."
TEST(Velocity, OfARotationIsThatOfTheAxisToSecondOrder) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const Vec3d axis = Vec3d(1, 2, -1).unit();
  const auto errorOf = [&](double angle) {
    const auto by = [&](double turn) { return [=](const Vec3d& x) { return turnedBy(turn, axis, x); }; };
    const auto expected = [&](const Vec3d& x) { return Vec3d(axis.cross(x) * (angle / kStep)); };
    return greatestVelocityError(
               mesh, {velocityMoment(mesh, -kStep, by(-angle)), velocityMoment(mesh, kStep, by(angle))}, expected) /
           (angle / kStep);
  };
  // sin(a) / a = 1 - a^2 / 6.
  EXPECT_NEAR(errorOf(0.2), 1.3 * 0.04 / 6, 0.001);
  EXPECT_NEAR(errorOf(0.2) / errorOf(0.1), 4, 0.05);
}

// Promise: "The velocity of a point ..."
TEST(Velocity, OfAStillSurfaceIsZero) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const auto still = [](const Vec3d& x) { return x; };
  const auto zero = [](const Vec3d&) { return Vec3d(0); };
  EXPECT_EQ(
      greatestVelocityError(mesh, {velocityMoment(mesh, -kStep, still), velocityMoment(mesh, kStep, still)}, zero), 0);
  EXPECT_EQ(greatestVelocityError(mesh, {}, zero), 0);
}

TEST(Velocity, OfASurfaceThatReturnsIsZero) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const auto away = [](const Vec3d& x) { return Vec3d(1.2 * x + Vec3d(0.1, 0.4, 0)); };
  const auto zero = [](const Vec3d&) { return Vec3d(0); };
  EXPECT_EQ(greatestVelocityError(mesh, {velocityMoment(mesh, -kStep, away), velocityMoment(mesh, kStep, away)}, zero),
            0);
}

// Promise: "The velocity of a point ..."
TEST(Velocity, OfGrowthFollowsTheDepth) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const double rate = 0.1 / kStep;
  const std::vector<SurfaceAt> moments = {velocityMoment(mesh, kStep, [](const Vec3d& x) { return Vec3d(1.1 * x); })};
  // What lies beside the surface moves away in proportion; or it keeps its distance, and goes as fast as the surface.
  const auto inProportion = [&](const Vec3d& x) { return Vec3d(rate * x); };
  EXPECT_LT(greatestVelocityError(mesh, moments, inProportion), 1e-10);
  const SurfaceVelocity kept(mesh, moments, MotionDepth::Kept);
  EXPECT_NEAR(kept.at(std::vector{1.3 * mesh.points[0]})[0].length(), rate, 0.01 * rate);
}

TEST(Velocity, OfTwoPartsIsThatOfTheNearerOne) {
  Mesh mesh = test_meshes::makeSphere(1, 2);
  const std::size_t first = mesh.points.size();
  const Mesh other = mesh;
  for (const Vec3d& point : other.points) mesh.points.push_back(point + Vec3d(3, 0, 0));
  for (const openvdb::Vec3I& t : other.triangles)
    mesh.triangles.push_back(t + openvdb::Vec3I(static_cast<openvdb::Vec3I::ValueType>(first)));
  SurfaceAt after =
      velocityMoment(mesh, kStep, [](const Vec3d& x) { return Vec3d(x + Vec3d(0, x[0] > 1.5 ? 1 : 0, 0)); });
  const auto expected = [](const Vec3d& x) { return Vec3d(0, x[0] > 1.5 ? 1 / kStep : 0, 0); };
  // Beside the surface, the map that fits best to both parts together shears a little.
  EXPECT_LT(greatestVelocityError(mesh, {after}, expected), 0.001 / kStep);
  const SurfaceVelocity velocity(mesh, std::vector{after}, MotionDepth::Stretched);
  const std::vector<Vec3d> found = velocity.at(mesh.points);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_LT((found[i] - expected(mesh.points[i])).length(), 1e-10);
}

TEST(Velocity, DoesNotDependOnTheBatch) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const SurfaceVelocity velocity(
      mesh,
      std::vector{velocityMoment(mesh, kStep, [](const Vec3d& x) { return Vec3d(x[0], 1.3 * x[1], x[2] * x[2]); })},
      MotionDepth::Stretched);
  const std::vector<Vec3d> places = placesAbout(mesh), together = velocity.at(places);
  for (std::size_t i = 0; i < places.size(); ++i) EXPECT_EQ(velocity.at({&places[i], 1})[0], together[i]);
}

TEST(Velocity, FacesThatDifferAreNamed) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const SurfaceAt other{kStep, std::make_shared<const Mesh>(test_meshes::makeSphere(1, 1)), "the mesh of frame 8"};
  try {
    SurfaceVelocity(mesh, std::vector{other}, MotionDepth::Stretched);
    FAIL() << "other faces were accepted";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("the mesh of frame 8"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("triangles"), std::string::npos) << error.what();
  }
}

}  // namespace
