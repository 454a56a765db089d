// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/camera.h"

#include "base/elementary.h"
#include "render/view.h"
#include "vdbtools/base/memory.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

constexpr double kParallel = 1e-6;  ///< directions whose angle has a smaller sine count as parallel
constexpr double kWidest = 150;     ///< maximum field of view, degrees

double radians(double degrees) { return degrees * (std::numbers::pi / 180); }

}  // namespace

void requireOption(bool good, const char* name, double value, const char* domain) {
  if (good) return;
  std::ostringstream text;
  text << "render: " << name << " must be " << domain << ", not " << value;
  throw std::invalid_argument(text.str());
}

void requireAngles(const ViewAngles& angles) {
  requireOption(std::isfinite(angles.azimuth), "azimuth", angles.azimuth, "finite");
  requireOption(angles.elevation >= -90 && angles.elevation <= 90, "elevation", angles.elevation, "-90 to 90 degrees");
  requireOption(angles.fieldOfView >= 1 && angles.fieldOfView <= kWidest, "fieldOfView", angles.fieldOfView,
                "1 to 150 degrees");
  requireOption(angles.zoom > 0 && std::isfinite(angles.zoom), "zoom", angles.zoom, "above 0");
}

Camera cameraAround(const FramedBall& ball, const ViewAngles& angles, double aspect, UpAxis up) {
  requireAngles(angles);
  const double a = radians(angles.azimuth), e = radians(angles.elevation);
  const Vec3d towardsEye(elementary::sin(a) * elementary::cos(e), elementary::sin(e),
                         elementary::cos(a) * elementary::cos(e));
  const double tangent = elementary::tan(0.5 * radians(angles.fieldOfView));
  Camera camera;
  camera.lookAt = ball.centre;
  const UpTurn turn(UpAxis::Y, up);
  camera.eye =
      ball.centre + ball.radius / elementary::sin(elementary::atan(tangent * std::min(1.0, aspect))) * turn(towardsEye);
  // At a pole, the up direction is the limit of views that approach it.
  if (elementary::cos(e) < kParallel)
    camera.up = (e > 0 ? -1.0 : 1.0) * Vec3d(elementary::sin(a), 0, elementary::cos(a));
  camera.up = turn(camera.up);
  camera.fieldOfView = 2 * elementary::atan(tangent / angles.zoom) / radians(1);
  return camera;
}

Camera turned(const Camera& camera, const Vec3d& axis, double degrees) {
  const Vec3d n = axis.unit();
  const double angle = radians(degrees), c = elementary::cos(angle), s = elementary::sin(angle);
  // Rodrigues' formula.
  const auto turn = [&](const Vec3d& origin, const Vec3d& v) {
    return origin + c * v + s * n.cross(v) + (1 - c) * n.dot(v) * n;
  };
  Camera result = camera;
  result.eye = turn(camera.lookAt, camera.eye - camera.lookAt);
  if (n.cross(camera.up) != Vec3d(0)) result.up = turn(Vec3d(0), camera.up);  // otherwise unchanged, without rounding
  return result;
}

CameraFrame frameOf(const Camera& camera) {
  requireOption(camera.fieldOfView > 0 && camera.fieldOfView < 180, "the camera's fieldOfView", camera.fieldOfView,
                "above 0 and below 180 degrees");
  const double distance = (camera.lookAt - camera.eye).length();
  requireOption(distance > 0 && std::isfinite(distance), "the distance from the eye to the look-at point", distance,
                "above 0");
  requireOption(camera.up.length() > 0 && std::isfinite(camera.up.length()), "the length of up", camera.up.length(),
                "above 0");
  CameraFrame frame;
  frame.forward = (camera.lookAt - camera.eye).unit();
  Vec3d up = camera.up.unit();
  if (frame.forward.cross(up).length() < kParallel)
    up = std::abs(frame.forward[2]) < 0.5 ? Vec3d(0, 0, -1) : Vec3d(0, 1, 0);
  frame.right = frame.forward.cross(up).unit();
  frame.up = frame.right.cross(frame.forward);
  frame.tangent = elementary::tan(0.5 * radians(camera.fieldOfView));
  return frame;
}

PixelSamples::PixelSamples(int width, int height, int samples)
    : mWidth(width), mHeight(height), mGrid(static_cast<int>(std::lround(std::sqrt(samples)))) {
  constexpr int kLargestSide = 32768;
  requireOption(width >= 1 && width <= kLargestSide, "width", width, "1 to 32768 pixels");
  requireOption(height >= 1 && height <= kLargestSide, "height", height, "1 to 32768 pixels");
  requireOption(samples == 1 || samples == 4 || samples == 9 || samples == 16, "samples", samples, "1, 4, 9 or 16");
  // Colours as floats, and codes for the file.
  constexpr double kBytesOfPixel = 15;
  requireMemory(kBytesOfPixel * width * height, MemoryUse::Picture,
                "a picture of " + std::to_string(width) + " x " + std::to_string(height) + " pixels");
}

}  // namespace vdbtools
