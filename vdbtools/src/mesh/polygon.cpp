// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon.h"

#include <limits>
#include <numeric>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

/// Ear clipping takes up to the cube of the corners; beyond this many it would look like a hang.
constexpr std::size_t kMostCornersToClip = 2000;

/// The area vector, twice over, of the triangle.
Vec3d normalOf(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return (b - a).cross(c - a); }

bool isConvex(std::span<const std::uint32_t> corners, const std::vector<Vec3d>& points, const Vec3d& normal) {
  const std::size_t n = corners.size();
  // All fan triangles the right way round: then the fan covers the polygon once.
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (normalOf(points[corners[0]], points[corners[i]], points[corners[i + 1]]).dot(normal) < 0) return false;
  }
  return true;
}

bool isEar(std::span<const std::uint32_t> corners, const std::vector<std::uint32_t>& ring, std::size_t i,
           const std::vector<Vec3d>& points, const Vec3d& normal) {
  const std::size_t n = ring.size();
  const std::size_t before = (i + n - 1) % n;
  const std::size_t after = (i + 1) % n;
  const Vec3d& a = points[corners[ring[before]]];
  const Vec3d& b = points[corners[ring[i]]];
  const Vec3d& c = points[corners[ring[after]]];
  if (normalOf(a, b, c).dot(normal) <= 0) return false;
  for (std::size_t k = 0; k < n; ++k) {
    if (k == before || k == i || k == after) continue;
    const Vec3d& p = points[corners[ring[k]]];
    if (normalOf(a, b, p).dot(normal) >= 0 && normalOf(b, c, p).dot(normal) >= 0 &&
        normalOf(c, a, p).dot(normal) >= 0) {
      return false;
    }
  }
  return true;
}

/// Calls emit(i, j, k) with the corners of each triangle, counted from 0.
template <class Emit>
void forEachTriangle(std::span<const std::uint32_t> corners, const std::vector<Vec3d>& points, const Emit& emit) {
  const std::size_t n = corners.size();
  std::vector<std::uint32_t> ring(n);
  std::iota(ring.begin(), ring.end(), 0U);
  if (n > 3 && n <= kMostCornersToClip) {
    Vec3d normal(0);  // Newell's, about the first corner to keep the digits
    for (std::size_t i = 1; i + 1 < n; ++i) {
      normal += normalOf(points[corners[0]], points[corners[i]], points[corners[i + 1]]);
    }
    if (!isConvex(corners, points, normal)) {
      bool found = true;
      while (ring.size() > 3 && found) {
        found = false;
        for (std::size_t i = 0; i < ring.size() && !found; ++i) {
          if (!isEar(corners, ring, i, points, normal)) continue;
          const std::size_t m = ring.size();
          emit(ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]);
          ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
          found = true;
        }
      }
    }
  }
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) emit(ring[0], ring[i], ring[i + 1]);
}

}  // namespace

void triangulatePolygon(std::span<const std::uint32_t> corners, const std::vector<Vec3d>& points,
                        std::vector<openvdb::Vec3I>& triangles) {
  forEachTriangle(corners, points, [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    triangles.emplace_back(corners[i], corners[j], corners[k]);
  });
}

void Polygons::triangulate(Mesh& mesh, std::span<const openvdb::Vec2s> uvs) const {
  const bool hasUvs = !mUvs.empty() && !uvs.empty();
  const auto uvAt = [&](std::size_t corner) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    return mUvs[corner] == kNoUv ? openvdb::Vec2s(kNone, kNone) : uvs[mUvs[corner]];
  };
  std::size_t begin = 0;
  for (const std::size_t end : mEnds) {
    const std::span corners = std::span(mCorners).subspan(begin, end - begin);
    forEachTriangle(corners, mesh.points, [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
      mesh.triangles.emplace_back(corners[i], corners[j], corners[k]);
      if (!hasUvs) return;
      for (const std::uint32_t corner : {i, j, k}) mesh.cornerUvs.push_back(uvAt(begin + corner));
    });
    begin = end;
  }
}

}  // namespace vdbtools
