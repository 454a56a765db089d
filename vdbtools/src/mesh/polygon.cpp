// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon.h"

#include <limits>
#include <numeric>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

/// Ear clipping takes time quadratic in the number of corners; beyond this many it would seem to hang.
constexpr std::size_t kMostCornersToClip = 2000;

/// Twice the area vector of the triangle.
Vec3d normalOf(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return (b - a).cross(c - a); }

bool isConvex(std::span<const std::uint32_t> corners, const std::vector<Vec3d>& points, const Vec3d& normal) {
  const std::size_t n = corners.size();
  // If all fan triangles have the right orientation, the fan covers the polygon once.
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (normalOf(points[corners[0]], points[corners[i]], points[corners[i + 1]]).dot(normal) < 0) return false;
  }
  return true;
}

/// The ring of remaining corners, and which of them are ears: corners whose triangle with their neighbours can be cut
/// off. A corner outside such a triangle stays outside, so results remain valid until a neighbour is removed. The whole
/// search is therefore quadratic in the number of corners.
class Ears {
 public:
  Ears(std::span<const std::uint32_t> corners, const std::vector<Vec3d>& points, const Vec3d& normal)
      : mCorners(corners), mPoints(points), mNormal(normal), mRing(corners.size()) {
    const auto n = static_cast<std::uint32_t>(corners.size());
    for (std::uint32_t i = 0; i < n; ++i) mRing[i] = {.before = (i + n - 1) % n, .after = (i + 1) % n};
  }

  std::uint32_t before(std::uint32_t i) const { return mRing[i].before; }
  std::uint32_t after(std::uint32_t i) const { return mRing[i].after; }
  bool isLeft(std::uint32_t i) const { return !mRing[i].gone; }

  bool isEar(std::uint32_t i) {
    Corner& corner = mRing[i];
    const Vec3d &a = at(corner.before), &b = at(i), &c = at(corner.after);
    if (corner.turn == Turn::Unknown) corner.turn = normalOf(a, b, c).dot(mNormal) <= 0 ? Turn::Inward : Turn::Outward;
    if (corner.turn == Turn::Inward) return false;
    for (; corner.checked < mRing.size(); ++corner.checked) {
      const std::uint32_t k = corner.checked;
      if (mRing[k].gone || k == corner.before || k == i || k == corner.after) continue;
      const Vec3d& p = at(k);
      if (normalOf(a, b, p).dot(mNormal) >= 0 && normalOf(b, c, p).dot(mNormal) >= 0 &&
          normalOf(c, a, p).dot(mNormal) >= 0)
        return false;
    }
    return true;
  }

  void cut(std::uint32_t i) {
    const auto [before, after] = std::pair(mRing[i].before, mRing[i].after);
    mRing[i].gone = true;
    mRing[before] = {.before = mRing[before].before, .after = after};
    mRing[after] = {.before = before, .after = mRing[after].after};
  }

 private:
  enum class Turn { Unknown, Outward, Inward };
  struct Corner {
    std::uint32_t before = 0, after = 0;
    std::uint32_t checked = 0;  ///< corners before this one are outside the triangle
    Turn turn = Turn::Unknown;
    bool gone = false;
  };

  const Vec3d& at(std::uint32_t i) const { return mPoints[mCorners[i]]; }

  std::span<const std::uint32_t> mCorners;
  const std::vector<Vec3d>& mPoints;
  Vec3d mNormal;
  std::vector<Corner> mRing;
};

/// Calls emit(i, j, k) with the corners of each triangle, counted from 0.
template <class Emit>
void forEachTriangle(std::span<const std::uint32_t> corners, const std::vector<Vec3d>& points, const Emit& emit) {
  const std::size_t n = corners.size();
  if (n == 3) return emit(0U, 1U, 2U);
  std::vector<std::uint32_t> ring(n);
  std::iota(ring.begin(), ring.end(), 0U);
  if (n > 3 && n <= kMostCornersToClip) {
    Vec3d normal(0);  // Newell's normal, relative to the first corner to keep precision
    for (std::size_t i = 1; i + 1 < n; ++i) {
      normal += normalOf(points[corners[0]], points[corners[i]], points[corners[i + 1]]);
    }
    if (!isConvex(corners, points, normal)) {
      Ears ears(corners, points, normal);
      std::size_t left = n;
      for (bool found = true; left > 3 && found;) {
        found = false;
        for (std::uint32_t i = 0; i < n && !found; ++i) {
          if (!ears.isLeft(i) || !ears.isEar(i)) continue;
          emit(ears.before(i), i, ears.after(i));
          ears.cut(i);
          --left;
          found = true;
        }
      }
      std::erase_if(ring, [&](std::uint32_t i) { return !ears.isLeft(i); });
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
  mesh.triangles.reserve(mesh.triangles.size() + mCorners.size() - 2 * size());
  for (std::size_t p = 0; p < size(); ++p) {
    const std::span corners = this->corners(p);
    forEachTriangle(corners, mesh.points, [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
      mesh.triangles.emplace_back(corners[i], corners[j], corners[k]);
      if (!hasUvs) return;
      for (const std::uint32_t corner : {i, j, k}) mesh.cornerUvs.push_back(uvAt(beginOf(p) + corner));
    });
  }
}

}  // namespace vdbtools
