// SPDX-License-Identifier: Apache-2.0
/// @file triangle_edges.h
/// The distance to the edges of a triangle, without OpenVDB.
#pragma once

#include <openvdb/Types.h>

#include <algorithm>
#include <limits>

namespace test_meshes {

inline double distanceToEdges(const openvdb::Vec3d (&corners)[3], const openvdb::Vec3d& position) {
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const openvdb::Vec3d a = corners[k], edge = corners[(k + 1) % 3] - a;
    const double length = edge.lengthSqr();
    const double s = length > 0 ? std::clamp(edge.dot(position - a) / length, 0.0, 1.0) : 0;
    least = std::min(least, (a + edge * s - position).length());
  }
  return least;
}

}  // namespace test_meshes
