// SPDX-License-Identifier: Apache-2.0
/// @file surface_distance.h
/// Proofs that one surface lies near another.
#pragma once

#include "search/surface_search.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

/// The corners of a triangle, or of a piece of one.
using TriangleCorners = std::array<openvdb::Vec3d, 3>;

/// An upper bound, for the sake of speed: for triangles that are not thin (triangle_point.h), the squared distance.
double squaredDistance(const openvdb::Vec3d& position, const TriangleCorners& triangle);

/// Proves that triangles lie near a surface.
///
/// The distance to a triangle is a convex function, so its maximum over a piece of a triangle is at a corner. Pieces
/// are halved until one triangle of the surface is near to all their corners, or their middle is far from all
/// triangles.
class NearProof {
 public:
  /// @param search        searches @a surface
  /// @param mostHalvings  a piece that is still undecided after so many counts as far
  NearProof(double limit, const Mesh& surface, const SurfaceSearch& search, int mostHalvings)
      : mLimit(limit), mSurface(surface), mSearch(search), mMostHalvings(mostHalvings) {}

  /// A place of a piece that is farther than the limit from the surface, or nearly so; none if all of the piece is
  /// near.
  /// @param likely  likely(position, nearby) is a triangle of the surface that is probably near, or none. nearby: the
  ///                triangle that was found for the piece of which this is a half, if any
  template <class Likely>
  std::optional<openvdb::Vec3d> farPlace(const TriangleCorners& piece, const Likely& likely) const {
    return farPlace(piece, likely, std::nullopt, 0);
  }

 private:
  /// After so many, the likely triangle is near, but does not suffice.
  static constexpr int kManyHalvings = 6;

  template <class Likely>
  std::optional<openvdb::Vec3d> farPlace(const TriangleCorners& piece, const Likely& likely,
                                         std::optional<std::uint32_t> nearby, int halvings) const {
    const openvdb::Vec3d middle = (piece[0] + piece[1] + piece[2]) / 3.0;
    nearby = likely(middle, nearby);
    if (nearby && isNearTo(piece, *nearby)) return std::nullopt;
    if (!nearby || halvings >= kManyHalvings || !isNear(middle, cornersOf(*nearby))) {
      const auto nearest = mSearch.nearest(middle, mLimit, nearby);
      if (!nearest) return middle;
      nearby = nearest->triangle;
      if (isNearTo(piece, *nearby)) return std::nullopt;
    }
    if (halvings >= mMostHalvings) return middle;
    const auto at = [](std::size_t corner) { return corner % 3; };
    std::size_t longest = 0;
    double square = -1;
    for (std::size_t c = 0; c < 3; ++c) {
      const double length = (piece[at(c + 1)] - piece[c]).lengthSqr();
      if (length > square) square = length, longest = c;
    }
    const openvdb::Vec3d &from = piece[longest], &to = piece[at(longest + 1)], &across = piece[at(longest + 2)];
    const openvdb::Vec3d half = (from + to) / 2.0;
    const auto far = farPlace({from, half, across}, likely, nearby, halvings + 1);
    return far ? far : farPlace({half, to, across}, likely, nearby, halvings + 1);
  }

  TriangleCorners cornersOf(std::uint32_t triangle) const {
    const openvdb::Vec3I& t = mSurface.triangles[triangle];
    return {mSurface.points[t[0]], mSurface.points[t[1]], mSurface.points[t[2]]};
  }

  bool isNear(const openvdb::Vec3d& place, const TriangleCorners& corners) const {
    return squaredDistance(place, corners) <= mLimit * mLimit;
  }

  bool isNearTo(const TriangleCorners& piece, std::uint32_t triangle) const {
    const TriangleCorners corners = cornersOf(triangle);
    return std::all_of(piece.begin(), piece.end(),
                       [&](const openvdb::Vec3d& corner) { return isNear(corner, corners); });
  }

  double mLimit;
  const Mesh& mSurface;
  const SurfaceSearch& mSearch;
  int mMostHalvings;
};

/// A place of a triangle that could not be proved to be near a surface.
struct FarPlace {
  std::uint32_t triangle = 0;
  openvdb::Vec3d place{0, 0, 0};
};

/// Finds the triangles of @a mesh with a point farther than @a limit from @a surface, vertex or not, and returns one
/// place of each. It may include triangles whose farthest point is nearer than that by a small fraction of the limit.
/// If there are none, no point of the mesh is farther away.
/// @param search  searches @a surface
/// @throw Interrupted
std::vector<FarPlace> placesFartherThan(double limit, const Mesh& mesh, const Mesh& surface,
                                        const SurfaceSearch& search, const Monitor& monitor);

}  // namespace vdbtools
