// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// The direction that is up in the picture.
Vec3d upOf(const Camera& camera) {
  const Vec3d forward = (camera.lookAt - camera.eye).unit();
  return forward.cross(camera.up).cross(forward).unit();
}

TEST(Camera, StandsWhereTheAnglesSay) {
  const FramedBall ball{Vec3d(3, -2, 5), 2};
  for (const double azimuth : {-30.0, 0.0, 90.0, 200.0})
    for (const double elevation : {-90.0, -89.0, -35.0, 0.0, 60.0, 90.0})
      for (const double fieldOfView : {5.0, 30.0, 120.0})
        for (const double zoom : {0.1, 1.0, 7.0})
          for (const double aspect : {0.5, 1.0, 2.0}) {
            const Camera camera = cameraAround(
                ball, {.azimuth = azimuth, .elevation = elevation, .fieldOfView = fieldOfView, .zoom = zoom}, aspect);
            EXPECT_EQ(camera.lookAt, ball.centre);
            const Vec3d arm = camera.eye - camera.lookAt;
            EXPECT_NEAR(std::asin(arm.unit()[1]), radians(elevation), 1e-6);
            if (std::abs(elevation) < 90) {
              EXPECT_NEAR(std::remainder(std::atan2(arm[0], arm[2]) - radians(azimuth), 2 * std::numbers::pi), 0, 1e-9);
            }
            // The ball touches the nearer edges, before the zoom.
            const double tangent = std::tan(radians(camera.fieldOfView) / 2);
            const double edge = std::atan(zoom * tangent * std::min(1.0, aspect));
            EXPECT_NEAR(std::asin(ball.radius / arm.length()), edge, 1e-9);
            EXPECT_NEAR(zoom * tangent, std::tan(radians(fieldOfView) / 2), 1e-9);
            // Nothing leans, and at the poles the azimuth still turns the picture.
            const Vec3d right = (-arm).cross(upOf(camera)).unit();
            EXPECT_NEAR(right.dot(Vec3d(std::cos(radians(azimuth)), 0, -std::sin(radians(azimuth)))), 1, 1e-9)
                << azimuth << ' ' << elevation;
          }
}

TEST(Camera, RefusesAnglesOutOfTheirRanges) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const ViewAngles& angles :
       {ViewAngles{.azimuth = kNaN}, ViewAngles{.elevation = 90.5}, ViewAngles{.elevation = kNaN},
        ViewAngles{.fieldOfView = 0.5}, ViewAngles{.fieldOfView = 151}, ViewAngles{.zoom = 0}, ViewAngles{.zoom = -1},
        ViewAngles{.zoom = std::numeric_limits<double>::infinity()}})
    EXPECT_THROW(cameraAround({Vec3d(0), 1}, angles, 1), std::invalid_argument);
}

TEST(Camera, ATurntableComesBack) {
  const Camera camera{.eye = Vec3d(4, 3, 2), .lookAt = Vec3d(1, 1, 1), .up = Vec3d(0.2, 1, 0)};
  for (const Vec3d& axis : {camera.up, Vec3d(0, 3, 0), Vec3d(1, 0, -1)}) {
    Camera around = camera;
    for (int i = 0; i < 8; ++i) {
      around = turned(around, axis, 45);
      EXPECT_NEAR((around.eye - camera.lookAt).length(), (camera.eye - camera.lookAt).length(), 1e-12);
      EXPECT_NEAR((around.eye - camera.eye).dot(axis), 0, 1e-12);
      EXPECT_NEAR(around.up.dot(axis), camera.up.dot(axis), 1e-12);
      if (i < 7) {
        EXPECT_GT((around.eye - camera.eye).length(), 0.5);
      }
    }
    EXPECT_LT((around.eye - camera.eye).length(), 1e-12);
    EXPECT_LT((around.up - camera.up).length(), 1e-12);
  }
  // Anticlockwise, seen from the end of the axis: from the front to +X.
  const Camera front{.eye = Vec3d(0, 0, 5)};
  EXPECT_LT((turned(front, Vec3d(0, 1, 0), 90).eye - Vec3d(5, 0, 0)).length(), 1e-12);
}

}  // namespace
