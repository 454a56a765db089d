// SPDX-License-Identifier: Apache-2.0
/// @file ray_tree.h
/// Intersects rays with triangles. The triangles are sorted along a Hilbert curve through their centres, four to a
/// pack, under a tree of boxes with eight children each. Results do not depend on the number of threads or on the
/// machine, which the existing libraries do not guarantee.
#pragma once

#include <openvdb/Types.h>
#include "vdbtools/base/monitor.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

class RayTree {
 public:
  /// Stores neither argument. Triangles need not be connected, and may be points or lines, which no ray meets.
  /// @param points  from -1 to 1 in each coordinate
  /// @pre there is a triangle, and there are fewer than 2^32 of them
  /// @throw Interrupted
  RayTree(const std::vector<openvdb::Vec3s>& points, const std::vector<openvdb::Vec3I>& triangles, Monitor& monitor);

  struct Hit {
    double distance = 0;  ///< in lengths of the direction
    std::uint32_t triangle = 0;
    double u = 0, v = 0;  ///< the barycentric weights of the triangle's second and third corner
  };
  /// The nearest triangle that the ray meets, from either side. @param direction  of about length 1
  std::optional<Hit> firstHit(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction) const;
  /// Whether the ray meets any triangle. @param origin  near the triangles
  bool blocked(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction) const;

 private:
  static constexpr std::uint32_t kChildren = 8, kLanes = 4;
  static constexpr int kMostLevels = 11;  ///< 4 * 8^10 triangles fill 10

  /// The boxes of up to eight children; unused boxes lie where no ray gets.
  struct alignas(32) Node {
    float low[3][kChildren], high[3][kChildren];
  };
  /// A corner of each triangle, and the edges from there.
  struct alignas(16) Pack {
    float corner[3][kLanes], second[3][kLanes], third[3][kLanes];
    std::array<std::uint32_t, kLanes> triangles;
  };
  struct Ray;

  template <bool Any>
  bool trace(const Ray& ray, Hit& hit) const;
  template <bool Any>
  static bool meets(const Pack& pack, const Ray& ray, Hit& hit);

  std::vector<Pack> mPacks;
  std::vector<std::vector<Node>> mLevels;  ///< the first has the boxes of the packs, the last is a single node
};

}  // namespace vdbtools
