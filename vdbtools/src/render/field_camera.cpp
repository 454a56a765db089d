// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/field_render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Vec3d;

constexpr int kFrameCells = 64;  ///< of the lattice that looks for the set, along the region's longest side

double radians(double degrees) { return degrees * (std::numbers::pi / 180); }
double longest(const Vec3d& v) { return std::max({v[0], v[1], v[2]}); }

}  // namespace

Camera turned(const Camera& camera, double degrees) {
  const Vec3d axis = camera.up.unit(), arm = camera.eye - camera.lookAt;
  const double angle = radians(degrees), c = std::cos(angle), s = std::sin(angle);
  Camera result = camera;
  result.eye = camera.lookAt + c * arm + s * axis.cross(arm) + (1 - c) * axis.dot(arm) * axis;
  return result;
}

FramedBall frameSet(const FieldSource& source, const BBoxd& region) {
  const double cell = longest(region.extents()) / kFrameCells;
  std::vector<julia::Point> points;
  std::vector<Vec3d> places;
  std::array<int, 3> count{};
  for (int axis = 0; axis < 3; ++axis)
    count[static_cast<std::size_t>(axis)] = std::max(1, static_cast<int>(std::ceil(region.extents()[axis] / cell)));
  for (int i = 0; i < count[0]; ++i)
    for (int j = 0; j < count[1]; ++j)
      for (int k = 0; k < count[2]; ++k) {
        places.push_back(region.min() + cell * Vec3d(i + 0.5, j + 0.5, k + 0.5));
        points.push_back(source.space.toFractal(places.back()));
      }
  std::vector<double> field(points.size());
  source.evaluator.evaluate(points, field, {});
  BBoxd box;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (field[i] < 0) box.expand(places[i]);
  if (box.empty()) return {region.getCenter(), 0.5 * region.extents().length()};
  FramedBall ball{box.getCenter(), 0};
  for (std::size_t i = 0; i < places.size(); ++i)
    if (field[i] < 0) ball.radius = std::max(ball.radius, (places[i] - ball.centre).length());
  ball.radius += cell;
  return ball;
}

Camera cameraAround(const FramedBall& ball, double azimuth, double elevation, double fieldOfView, double zoom,
                    double aspect) {
  const double a = radians(azimuth), e = radians(elevation);
  const Vec3d towardsEye(std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e));
  const double tangent = std::tan(0.5 * radians(fieldOfView));
  Camera camera;
  camera.lookAt = ball.centre;
  camera.eye = ball.centre + ball.radius / std::sin(std::atan(tangent * std::min(1.0, aspect))) * towardsEye;
  camera.fieldOfView = 2 * std::atan(tangent / zoom) / radians(1);
  return camera;
}

}  // namespace vdbtools
