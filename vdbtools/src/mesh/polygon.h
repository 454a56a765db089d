// SPDX-License-Identifier: Apache-2.0
/// @file polygon.h
/// The polygons of mesh files, and their triangulation.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace vdbtools {

/// Appends the triangles of one polygon to @a triangles: corners.size() - 2 of them, with the polygon's orientation. A
/// convex polygon becomes a fan about its first corner. A concave one is clipped ear by ear in the plane of its mean
/// normal; if no ear is found (because it intersects itself, or is very large), it becomes a fan, too.
/// @param corners  indices into @a points, three or more
void triangulatePolygon(std::span<const std::uint32_t> corners, const std::vector<openvdb::Vec3d>& points,
                        std::vector<openvdb::Vec3I>& triangles);

/// Polygons that are stored until all points are known, because in some formats faces may precede their points.
class Polygons {
 public:
  static constexpr std::uint32_t kNoUv = 0xffffffff;

  /// Makes room for this many triangles.
  void reserve(std::size_t triangles) { mCorners.reserve(3 * triangles); }
  /// @param corners  indices of points, three or more
  void add(std::span<const std::uint32_t> corners) {
    if (corners.size() != 3 && mEnds.empty())
      for (std::size_t end = 3; end <= mCorners.size(); end += 3) mEnds.push_back(end);
    const bool hasEnds = !mEnds.empty() || corners.size() != 3;
    mCorners.insert(mCorners.end(), corners.begin(), corners.end());
    if (hasEnds) mEnds.push_back(mCorners.size());
    if (!mUvs.empty()) mUvs.resize(mCorners.size(), kNoUv);
  }
  /// @param uvs  for each corner, its index of texture coordinates, or kNoUv
  void add(std::span<const std::uint32_t> corners, std::span<const std::uint32_t> uvs) {
    mUvs.resize(mCorners.size(), kNoUv);
    mUvs.insert(mUvs.end(), uvs.begin(), uvs.end());
    add(corners);
  }
  bool empty() const { return mCorners.empty(); }
  std::size_t size() const { return mEnds.empty() ? mCorners.size() / 3 : mEnds.size(); }
  /// The corners of polygon @a i, as they were added.
  std::span<const std::uint32_t> corners(std::size_t i) const {
    const std::size_t begin = beginOf(i);
    return std::span(mCorners).subspan(begin, beginOf(i + 1) - begin);
  }

  /// Appends the triangles of all polygons to @a mesh. @pre every corner is one of its points
  void triangulate(Mesh& mesh) const { triangulate(mesh, {}); }
  /// As above, with texture coordinates if any corner has them. @pre every index of one is below uvs.size()
  void triangulate(Mesh& mesh, std::span<const openvdb::Vec2s> uvs) const;

 private:
  std::size_t beginOf(std::size_t i) const { return mEnds.empty() ? 3 * i : i == 0 ? 0 : mEnds[i - 1]; }

  std::vector<std::uint32_t> mCorners;
  std::vector<std::size_t> mEnds;     ///< the end of each polygon in mCorners; empty if all are triangles
  std::vector<std::uint32_t> mUvs{};  ///< for each corner, or empty
};

}  // namespace vdbtools
