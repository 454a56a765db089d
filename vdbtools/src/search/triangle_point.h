// SPDX-License-Identifier: Apache-2.0
/// @file triangle_point.h
/// The point of one triangle that is nearest to a position.
#pragma once

#include <openvdb/Types.h>

namespace vdbtools {

/// As openvdb::math::closestPointOnTriangleToPoint(), but also right for triangles whose corners lie on a line. There,
/// rounding decides for OpenVDB's function which part of the triangle is near, and it may return any point of it.
/// @param weights  receives the barycentric weights of the returned point
/// @pre all coordinates are finite
openvdb::Vec3d nearestOnTriangle(const openvdb::Vec3d& a, const openvdb::Vec3d& b, const openvdb::Vec3d& c,
                                 const openvdb::Vec3d& position, openvdb::Vec3d& weights);

/// Whether a triangle is so thin that OpenVDB's function may be wrong by more than its tolerance, a ten-millionth of
/// the coordinates. It is false for nearly all triangles of a mesh.
bool isThin(const openvdb::Vec3d& a, const openvdb::Vec3d& b, const openvdb::Vec3d& c);

}  // namespace vdbtools
