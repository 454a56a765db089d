// SPDX-License-Identifier: Apache-2.0
/// @file triangle_cut.h
/// Cuts a triangle along segments in its plane. All lengths are in voxels.
#pragma once

#include <openvdb/Types.h>

#include <vector>

namespace vdbtools {

/// Points that are closer to each other than this count as coincident, and narrower polygons as slivers. Coordinates
/// that a file stores as floats have larger errors than doubles: 2e-6 for 50 voxels about the origin.
inline constexpr double kTouch = 1e-5;

/// In the plane of a triangle.
struct PlaneSegment {
  openvdb::Vec2d from, to;
};

/// Corners in the plane of a triangle, counter-clockwise.
using ConvexPolygon = std::vector<openvdb::Vec2d>;

/// A triangle's plane, and positions in it.
class TrianglePlane {
 public:
  /// @pre not a sliver
  TrianglePlane(const openvdb::Vec3d& a, const openvdb::Vec3d& b, const openvdb::Vec3d& c) : mOrigin(a) {
    mFirst = b - a;
    mFirst.normalize();
    mNormal = (b - a).cross(c - a);
    mNormal.normalize();
    mSecond = mNormal.cross(mFirst);
  }

  const openvdb::Vec3d& normal() const { return mNormal; }
  double height(const openvdb::Vec3d& p) const { return mNormal.dot(p - mOrigin); }
  openvdb::Vec2d flat(const openvdb::Vec3d& p) const { return {mFirst.dot(p - mOrigin), mSecond.dot(p - mOrigin)}; }
  openvdb::Vec3d space(const openvdb::Vec2d& p) const { return mOrigin + mFirst * p[0] + mSecond * p[1]; }

 private:
  openvdb::Vec3d mOrigin, mFirst, mSecond, mNormal;
};

/// The part of a segment that is at least @a inset within the polygon's edges; from = to: none. With a negative inset
/// the segment may be outside by as much.
PlaneSegment clipped(const PlaneSegment& segment, const ConvexPolygon& polygon, double inset);

/// Whether a segment is longer than kTouch.
bool isLong(const PlaneSegment& segment);

/// Cuts a polygon until no segment passes through a piece by more than kTouch from the piece's edges. The pieces tile
/// the polygon, but for slivers, which are left out.
std::vector<ConvexPolygon> piecesOf(const ConvexPolygon& polygon, const std::vector<PlaneSegment>& segments);

}  // namespace vdbtools
