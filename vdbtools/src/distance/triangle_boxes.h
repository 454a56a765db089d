// SPDX-License-Identifier: Apache-2.0
/// @file triangle_boxes.h
/// Finds the triangles of a mesh that may meet a box or a ray.
#pragma once

#include "vdbtools/base/grids.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbtools {

/// A balanced binary tree of boxes. Node i has the children 2 i and 2 i + 1; the last half of the nodes are leaves.
class TriangleBoxes {
 public:
  /// Keeps references to both arguments.
  TriangleBoxes(const std::vector<openvdb::Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles);
  TriangleBoxes(const TriangleBoxes&) = delete;
  TriangleBoxes& operator=(const TriangleBoxes&) = delete;

  /// Calls visit(triangle) for each triangle whose bounding box meets @a box; the boxes include their faces.
  template <class Visit>
  void meeting(const openvdb::BBoxd& box, const Visit& visit) const {
    walk([&](const openvdb::BBoxd& node) { return node.hasOverlap(box); }, visit);
  }

  /// Calls visit(triangle) for all triangles that a ray meets, within @a slack, and possibly others nearby.
  /// @param direction  no component is 0
  template <class Visit>
  void along(const openvdb::Vec3d& start, const openvdb::Vec3d& direction, double slack, const Visit& visit) const {
    const openvdb::Vec3d inverse = 1.0 / direction;
    const auto meets = [&](const openvdb::BBoxd& node) {
      double from = -2 * slack, to = std::numeric_limits<double>::infinity();
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (node.min()[axis] - slack - start[axis]) * inverse[axis],
                     b = (node.max()[axis] + slack - start[axis]) * inverse[axis];
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
      }
      return from <= to;
    };
    walk(meets, visit);
  }

 private:
  template <class Meets, class Visit>
  void walk(const Meets& meets, const Visit& visit) const {
    std::size_t stack[64];
    std::size_t depth = 0;
    stack[depth++] = 1;
    while (depth > 0) {
      const std::size_t node = stack[--depth];
      if (!meets(mBoxes[node])) continue;
      if (node < mLeaves) {
        stack[depth++] = 2 * node + 1;
        stack[depth++] = 2 * node;
        continue;
      }
      for (std::size_t i = firstOf(node - mLeaves); i < firstOf(node - mLeaves + 1); ++i)
        if (meets(boxOf(mOrder[i]))) visit(mOrder[i]);
    }
  }

  std::size_t firstOf(std::size_t leaf) const { return leaf * mOrder.size() / mLeaves; }
  openvdb::BBoxd boxOf(std::uint32_t triangle) const;
  void arrange(std::size_t node, std::size_t firstLeaf, std::size_t leaves);

  const std::vector<openvdb::Vec3d>& mPoints;
  const std::vector<openvdb::Vec3I>& mTriangles;
  std::vector<std::uint32_t> mOrder;
  std::size_t mLeaves = 1;
  std::vector<openvdb::BBoxd> mBoxes;
};

}  // namespace vdbtools
