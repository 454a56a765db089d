// SPDX-License-Identifier: Apache-2.0
#include "study/study_circles.h"

#include "base/in_parallel.h"
#include "distance/wide_distance.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

constexpr std::size_t kRadii = 257;        ///< from 0 on
constexpr std::size_t kDirections = 1024;  ///< points of a sphere

/// Evenly spaced points of the unit circle, by halving angles, because sines differ between C libraries.
std::vector<std::array<double, 2>> unitCircle() {
  std::vector<std::array<double, 2>> points{{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  while (points.size() < StudyCircles::kAngles) {
    std::vector<std::array<double, 2>> finer;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto &a = points[i], &b = points[(i + 1) % points.size()];
      const double x = a[0] + b[0], y = a[1] + b[1], length = std::sqrt(x * x + y * y);
      finer.push_back(a);
      finer.push_back({x / length, y / length});
    }
    points = std::move(finer);
  }
  return points;
}

/// Points of the unit sphere with about equal areas: a spiral that turns by the golden angle.
std::vector<Vec3d> unitSphere() {
  constexpr double kCosine = -0.73736887807831990, kSine = 0.67549029426152364;  // of pi (3 - sqrt 5)
  std::vector<Vec3d> points;
  double x = 1, y = 0;
  for (std::size_t i = 0; i < kDirections; ++i) {
    const double z = (2 * static_cast<double>(i) + 1) / kDirections - 1, r = std::sqrt(1 - z * z);
    points.emplace_back(r * x, r * y, z);
    const double turned = x * kCosine - y * kSine;
    y = x * kSine + y * kCosine;
    x = turned;
    const double length = std::sqrt(x * x + y * y);
    x /= length;
    y /= length;
  }
  return points;
}

double meanOf(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

StudyCircles::StudyCircles(const SlicePlane& plane, const Vec3d& origin) : mOrigin(origin), mUnit(unitCircle()) {
  const Vec3d corner = plane.position(0, 0);
  mRight = (plane.position(1, 0) - corner).unit();
  mDown = (plane.position(0, 1) - corner).unit();
  const Vec3d normal = mRight.cross(mDown);
  mCentre = origin + normal * normal.dot(corner - origin);
  for (const int x : {0, plane.width() - 1})
    for (const int y : {0, plane.height() - 1})
      mFarthest = std::max(mFarthest, (plane.position(x, y) - mCentre).length());
}

double StudyCircles::radius(std::size_t circle) const { return mFarthest * static_cast<double>(circle) / (kRadii - 1); }

Vec3d StudyCircles::position(std::size_t circle, std::size_t angle) const {
  const auto& [x, y] = mUnit[angle];
  return mCentre + (mRight * x + mDown * y) * radius(circle);
}

std::vector<StudyCircle> StudyCircles::measure(const Scene& scene, Monitor& monitor) const {
  monitor.begin(PhaseKind::Distances, 0);
  openvdb::BBoxd box(mCentre, mCentre);
  box.expand(mOrigin);
  constexpr double kRounding = 1.001;
  box.expand(kRounding * mFarthest);
  const WideDistance distance(scene.target->distances, box, monitor);
  const std::vector<Vec3d> directions = unitSphere();
  std::vector<StudyCircle> circles(kRadii);
  inParallel(kRadii, 1, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3d> points;
    std::vector<double> phi;
    const auto sample = [&] {
      phi.resize(points.size());
      distance.sample(points, phi);
      points.clear();
    };
    for (std::size_t i = begin; i != end; ++i) {
      StudyCircle& circle = circles[i];
      circle.radius = radius(i);
      for (std::size_t k = 0; k < kAngles; ++k) points.push_back(position(i, k));
      sample();
      circle.mean = meanOf(phi);
      circle.least = *std::min_element(phi.begin(), phi.end());
      circle.greatest = *std::max_element(phi.begin(), phi.end());
      for (const Vec3d& direction : directions) points.push_back(mOrigin + direction * circle.radius);
      sample();
      circle.sphereMean = meanOf(phi);
    }
  });
  return circles;
}

}  // namespace vdbtools
