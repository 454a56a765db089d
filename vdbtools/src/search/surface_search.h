// SPDX-License-Identifier: Apache-2.0
/// @file surface_search.h
/// The nearest point of a mesh, from anywhere: a tree of boxes around triangles, searched from the nearer box on.
#pragma once

#include <openvdb/Types.h>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace vdbtools {

/// A point of a surface: a triangle, and the weights of its corners, which add up to 1.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  openvdb::Vec3d weights{0, 0, 0};
  double distance = 0;  ///< from where it was searched for
};

/// May be searched in many threads at once. The mesh may be open, and its triangles may cross.
class SurfaceSearch {
 public:
  /// @param points  whose differences are of ordinary size: thousandths to millions
  /// @pre every index is below points.size()
  SurfaceSearch(std::vector<openvdb::Vec3d> points, std::vector<openvdb::Vec3I> triangles);

  /// The nearest point no farther away than @a within, if there is one; of several triangles equally near, to rounding,
  /// the first.
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
    std::uint32_t first = 0;  ///< of a leaf's triangles in mOrder; otherwise the second child's node
    std::uint32_t count = 0;  ///< of a leaf's triangles; 0: the first child is the next node
  };
  void build(std::uint32_t begin, std::uint32_t end, const std::vector<openvdb::Vec3d>& middles);
  /// Takes the triangle's nearest point where that is better than @a best.
  void meet(std::uint32_t triangle, const openvdb::Vec3d& position, SurfacePoint& best, double& bestSquared) const;

  std::vector<openvdb::Vec3d> mPoints;
  std::vector<openvdb::Vec3I> mTriangles;
  std::vector<std::uint32_t> mOrder;  ///< of the triangles
  std::vector<Node> mNodes;           ///< the root first
};

}  // namespace vdbtools
