// SPDX-License-Identifier: Apache-2.0
#include "search/triangle_point.h"

#include <openvdb/math/Proximity.h>

#include <algorithm>
#include <array>

namespace vdbtools {

using openvdb::Vec3d;

Vec3d nearestOnTriangle(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& position, Vec3d& weights) {
  Vec3d nearest = openvdb::math::closestPointOnTriangleToPoint(a, b, c, position, weights);
  const std::array corners = {&a, &b, &c};
  // A point of a convex set is the nearest one exactly if, seen from it, nothing of the set lies toward the position.
  // Up to this cosine it is rounding, which adds less than 1e-14 of the distance.
  constexpr double kRounding = 1e-7;
  const Vec3d away = position - nearest;
  const bool isNearest = std::none_of(corners.begin(), corners.end(), [&](const Vec3d* corner) {
    const Vec3d along = *corner - nearest;
    const double toward = away.dot(along);
    return !(toward <= 0) && !(toward * toward <= kRounding * kRounding * away.lengthSqr() * along.lengthSqr());
  });
  if (isNearest) return nearest;
  double least = away.lengthSqr();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    double share = 0;
    const Vec3d point = openvdb::math::closestPointOnSegmentToPoint(*corners[k], *corners[next], position, share);
    const double squared = (point - position).lengthSqr();
    if (least <= squared) continue;
    least = squared;
    nearest = point;
    weights = Vec3d(0);
    weights[static_cast<int>(k)] = 1 - share;
    weights[static_cast<int>(next)] = share;
  }
  return nearest;
}

bool isThin(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  constexpr double kThin = 1e-4;  // the height, as a part of the longest side; larger errors were seen below 1e-11
  const Vec3d p = b - a, q = c - a;
  const double longest = std::max({p.lengthSqr(), q.lengthSqr(), (q - p).lengthSqr()});
  return !(p.cross(q).lengthSqr() > kThin * kThin * longest * longest);
}

}  // namespace vdbtools
