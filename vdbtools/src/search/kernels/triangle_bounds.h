// SPDX-License-Identifier: Apache-2.0
/// @file triangle_bounds.h
/// Which triangles and boxes may be nearest somewhere in a cube. See triangle_bodies.h, which alone includes it, for
/// the bound.
#pragma once

#include "search/kernels/triangle_lanes.h"

namespace vdbtools::kernels {
namespace {

inline void toCentre(const TreeView& tree, const double position[3], float (&p)[3]) {
  for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(position[axis] - tree.centre[axis]);
}

/// Upper bounds of the distances from a cube's corners to a triangle.
struct CornerBounds {
  float at[8];
};

/// The corners of a cube whose half side is 1.
constexpr float kCorner[3][8] = {
    {-1, -1, -1, -1, 1, 1, 1, 1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, 1, -1, 1, -1, 1, -1, 1}};

/// Eight corners relative to another point, as lanes first to first + kNodesWide.
inline NodeFloats corners(int axis, unsigned first, float half, float about) {
  return load<NodeFloats>(kCorner[axis] + first) * half + about;
}

/// @param slack  error bound of the triangle's distances
inline CornerBounds cornerBounds(const Triangle<float>& triangle, const float about[3], float half, float slack) {
  CornerBounds bounds;
  for (unsigned k = 0; k < 8; k += kNodesWide) {
    const NodeFloats squared = awayFrom<NodeFloats>(triangle, corners(0, k, half, about[0]),
                                                    corners(1, k, half, about[1]), corners(2, k, half, about[2]))
                                   .squared;
    store(squareRoot(squared) * 1.00001F + slack, bounds.at + k);
  }
  return bounds;
}

/// By how much something is too far to be nearest anywhere in a cube; if at most 0, it may be nearest.
/// @param x, y, z  the vector from its nearest point to the cube's centre
/// @param slack  by how much its distance may be overestimated
template <class V>
inline V excess(V x, V y, V z, V squared, float half, V slack, const CornerBounds& bounds) {
  const V distance = squareRoot(squared);
  const V scale = half / (distance + 1e-20F);
  x *= scale, y *= scale, z *= scale;
  const V base = distance * 0.999998F - slack;
  const V ll = base - x - y, lh = base - x + y, hl = base + x - y, hh = base + x + y;
  return lesser(lesser(lesser(ll - z - bounds.at[0], ll + z - bounds.at[1]),
                       lesser(lh - z - bounds.at[2], lh + z - bounds.at[3])),
                lesser(lesser(hl - z - bounds.at[4], hl + z - bounds.at[5]),
                       lesser(hh - z - bounds.at[6], hh + z - bounds.at[7])));
}

/// By how much something is farther than @a far everywhere in a cube, with the arguments of excess().
template <class V>
inline V excessOver(float far, V x, V y, V z, V squared, float half, V slack) {
  const V distance = squareRoot(squared);
  const V scale = half / (distance + 1e-20F);
  const auto absolute = [](V v) { return greater(v, -v); };
  return distance * 0.999998F - slack - scale * (absolute(x) + absolute(y) + absolute(z)) - far;
}

/// The triangle nearest to a cube's centre, with the data for comparing others with it.
struct Nearest {
  CornerBounds bounds;
  float distance;   ///< an upper bound
  float x, y, z;    ///< the unit vector to the cube's centre
  float curvature;  ///< an upper bound of how far the distance exceeds its tangent at the corners
};

/// A lower bound of excess(). From the nearest point q of B, dist(p, B) is at most |p - q|, which is at most dist(c, B)
/// + n (p - c) + |p - c|^2 / (2 dist(c, B)). This is much cheaper, and as good far from the surface.
template <class V>
inline V farExcess(V x, V y, V z, V squared, float half, V slack, const Nearest& b) {
  const V distance = squareRoot(squared);
  const V scale = 1 / (distance + 1e-20F);
  const auto absolute = [](V v) { return greater(v, -v); };
  return distance * 0.999998F - slack - b.distance - b.curvature -
         half * (absolute(x * scale - b.x) + absolute(y * scale - b.y) + absolute(z * scale - b.z));
}

/// The error bound of a triangle's distances in floats.
template <class V>
inline V slackOf(const Triangle<V>& t) {
  return 4e-6F * (t.b + t.d);
}

/// One of several triangles.
inline Triangle<float> laneOf(const Triangle<NodeFloats>& lanes, unsigned lane) {
  Triangle<float> triangle;
  float* const to = &triangle.ax;
  const auto* from = reinterpret_cast<const NodeFloats*>(&lanes);
  for (unsigned l = 0; l < sizeof(triangle) / sizeof(float); ++l) to[l] = from[l][lane];
  return triangle;
}

/// A triangle relative to a position.
inline Triangle<float> triangleAt(const TreeView& tree, Place place, const double position[3]) {
  const unsigned first = place.lane / kNodesWide * kNodesWide;
  return laneOf(trianglesOf<NodeFloats>(tree.packs[place.pack], first, position), place.lane - first);
}

/// @param slack  error bound of the triangle's distances
inline Nearest nearestOf(const Triangle<float>& t, const float about[3], float half, float slack) {
  Nearest result;
  result.bounds = cornerBounds(t, about, half, slack);
  const NodeFloats zero = {};
  const Away<NodeFloats> away = awayFrom<NodeFloats>(t, zero + about[0], zero + about[1], zero + about[2]);
  const float distance = std::sqrt(away.squared[0]), scale = 1 / (distance + 1e-20F);
  const float x = away.x[0] * scale, y = away.y[0] * scale, z = away.z[0] * scale;
  result.distance = distance * 1.00001F + slack;
  result.x = x * t.ux + y * t.vx + z * t.nx;
  result.y = x * t.uy + y * t.vy + z * t.ny;
  result.z = x * t.uz + y * t.vz + z * t.nz;
  result.curvature = 1.5F * half * half / (distance + 1e-20F);
  return result;
}

/// Some triangles relative to a position. Their floats depend only on the triangle and the position, so a node gets the
/// same distance from any part of the mesh that contains its nearest triangle.
inline Triangle<NodeFloats> trianglesAt(const TreeView& tree, const std::uint32_t* numbers, const double position[3]) {
  float at[3][3][kNodesWide];
  for (unsigned k = 0; k < kNodesWide; ++k) {
    const std::uint32_t* const corner = tree.triangles + 3 * std::size_t{numbers[k]};
    const double* const a = tree.points + 3 * std::size_t{corner[0]};
    const double* const b = tree.points + 3 * std::size_t{corner[1]};
    const double* const c = tree.points + 3 * std::size_t{corner[2]};
    for (unsigned axis = 0; axis < 3; ++axis) {
      at[0][axis][k] = static_cast<float>(a[axis] - position[axis]);
      at[1][axis][k] = static_cast<float>(b[axis] - a[axis]);
      at[2][axis][k] = static_cast<float>(c[axis] - a[axis]);
    }
  }
  const auto v = [&](unsigned of, unsigned axis) { return load<NodeFloats>(at[of][axis]); };
  return frameOf<NodeFloats>(v(0, 0), v(0, 1), v(0, 2), v(1, 0), v(1, 1), v(1, 2), v(2, 0), v(2, 1), v(2, 2));
}

}  // namespace
}  // namespace vdbtools::kernels
