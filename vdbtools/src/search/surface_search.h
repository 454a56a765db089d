// SPDX-License-Identifier: Apache-2.0
/// @file surface_search.h
/// Finds the point of a mesh nearest to a position, with a tree of boxes around triangles, searched from the nearer box
/// on.
#pragma once

#include <openvdb/Types.h>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace vdbtools {

/// A point of a surface: a triangle, and the barycentric weights of its corners.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  openvdb::Vec3d weights{0, 0, 0};
  double distance = 0;  ///< from the position that was searched for
};

/// What has a value at each corner, at a point of a triangle with these barycentric weights. Where the corners have the
/// same value, it is unchanged.
/// @param corner  the value at corner 0, 1 or 2
template <class Corner>
auto interpolated(const openvdb::Vec3d& weights, const Corner& corner) {
  const auto first = corner(0);
  return first + (corner(1) - first) * weights[1] + (corner(2) - first) * weights[2];
}

/// Many threads may search it at once. The mesh may be open, and its triangles may intersect.
class SurfaceSearch {
 public:
  /// @param points  with differences of ordinary size: thousandths to millions
  /// @pre every index is below points.size()
  SurfaceSearch(std::vector<openvdb::Vec3d> points, std::vector<openvdb::Vec3I> triangles);

  /// Finds the nearest point at most @a within away, if there is one; of several triangles equally near, up to
  /// rounding, the first is chosen.
  /// @param hint  a triangle that is probably near, which makes the search faster
  std::optional<SurfacePoint> nearest(const openvdb::Vec3d& position,
                                      double within = std::numeric_limits<double>::infinity(),
                                      std::optional<std::uint32_t> hint = std::nullopt) const;

 private:
  struct Box {
    std::array<double, 3> low, high;
    double distanceSquared(const openvdb::Vec3d& p) const;
  };
  struct Node {
    Box box;
    std::uint32_t first = 0;  ///< the first of a leaf's triangles in mOrder; otherwise the second child's node
    std::uint32_t count = 0;  ///< the number of a leaf's triangles; 0: the first child is the next node
  };
  void build(std::uint32_t begin, std::uint32_t end, const std::vector<openvdb::Vec3d>& middles);
  /// Replaces @a best by the triangle's nearest point if that is nearer.
  void meet(std::uint32_t triangle, const openvdb::Vec3d& position, SurfacePoint& best, double& bestSquared) const;

  std::vector<openvdb::Vec3d> mPoints;
  std::vector<openvdb::Vec3I> mTriangles;
  std::vector<std::uint32_t> mOrder;  ///< the triangles, sorted for the leaves
  std::vector<Node> mNodes;           ///< the root first
  std::vector<bool> mThin;            ///< of the triangles
};

}  // namespace vdbtools
