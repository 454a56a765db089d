// SPDX-License-Identifier: Apache-2.0
/// @file triangle_lanes.h
/// Vectors of numbers, and distances to triangles computed with them. Only triangle_bounds.h includes it.
#pragma once

#include "search/kernels/triangle_kernels.h"

#include <cmath>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace vdbtools::kernels {
namespace {

constexpr unsigned kWide = JULIA_FLOATS;
constexpr float kHuge = 1e30F;

typedef float Floats __attribute__((vector_size(4 * kWide)));
typedef std::int32_t Numbers __attribute__((vector_size(4 * kWide)));

/// The lanes for the nodes of a cube of 2^3, and for the children of a node.
constexpr unsigned kNodesWide = kWide < 8 ? kWide : 8;
typedef float NodeFloats __attribute__((vector_size(4 * kNodesWide)));
typedef std::int32_t NodeNumbers __attribute__((vector_size(4 * kNodesWide)));
constexpr unsigned kDoublesWide = kWide / 2;
typedef double Doubles __attribute__((vector_size(8 * kDoublesWide)));

template <class V, class T>
inline V load(const T* from) {
  V value;
  __builtin_memcpy(&value, from, sizeof(V));
  return value;
}

template <class V, class T>
inline void store(const V& value, T* to) {
  __builtin_memcpy(to, &value, sizeof(V));
}

template <class V>
inline V lesser(V a, V b) {
  return a < b ? a : b;
}

template <class V>
inline V greater(V a, V b) {
  return a > b ? a : b;
}

template <class V>
inline V squareRoot(V x) {
  V result;
  for (unsigned k = 0; k < sizeof(V) / sizeof(x[0]); ++k) result[k] = std::sqrt(x[k]);
  return result;
}

/// A triangle in its own frame: corner a, unit vectors u, v in its plane and n perpendicular to it; the other corners
/// are b u and c u + d v, where d is not negative.
template <class V>
struct Triangle {
  V ax, ay, az, ux, uy, uz, vx, vy, vz, nx, ny, nz;
  V b, c, d;
  V perC, perD;  ///< 1 / (c^2 + d^2) and 1 / ((c - b)^2 + d^2); 0 if undefined
};

template <class V>
inline V dot(V ax, V ay, V az, V bx, V by, V bz) {
  return ax * bx + ay * by + az * bz;
}

template <class V>
inline V reciprocal(V x) {
  const V zero = {};
  return x > zero ? 1 / x : zero;
}

/// @param p, q  the edges from the corner a
template <class V>
inline Triangle<V> frameOf(V ax, V ay, V az, V px, V py, V pz, V qx, V qy, V qz) {
  const V zero = {}, one = zero + 1;
  Triangle<V> t;
  t.ax = ax, t.ay = ay, t.az = az;
  // The longer edge gives u, and the rest of the other one gives v.
  const V pp = dot(px, py, pz, px, py, pz), qq = dot(qx, qy, qz, qx, qy, qz);
  const auto swaps = qq > pp;
  const V lx = swaps ? qx : px, ly = swaps ? qy : py, lz = swaps ? qz : pz;
  const V sx = swaps ? px : qx, sy = swaps ? py : qy, sz = swaps ? pz : qz;
  t.b = squareRoot(swaps ? qq : pp);
  const V perB = reciprocal(t.b);
  const auto isPoint = !(t.b > zero);
  t.ux = isPoint ? one : lx * perB, t.uy = ly * perB, t.uz = lz * perB;
  t.c = dot(sx, sy, sz, t.ux, t.uy, t.uz);
  const V rx = sx - t.c * t.ux, ry = sy - t.c * t.uy, rz = sz - t.c * t.uz;
  t.d = squareRoot(dot(rx, ry, rz, rx, ry, rz));
  // If the corners are collinear, v is any vector perpendicular to u.
  const V perD = reciprocal(t.d);
  const auto isRow = !(t.d > 1e-6F * t.b);
  const V bx = t.ux < zero ? -t.ux : t.ux, by = t.uy < zero ? -t.uy : t.uy, bz = t.uz < zero ? -t.uz : t.uz;
  const auto isX = (bx <= by) & (bx <= bz);
  const auto isY = by <= bz;
  t.d = isRow ? zero : t.d;
  t.vx = isRow ? (isX ? one : zero) : rx * perD;
  t.vy = isRow ? (isX ? zero : isY ? one : zero) : ry * perD;
  t.vz = isRow ? (isX ? zero : isY ? zero : one) : rz * perD;
  // Orthogonalise again, because rounding leaves a component along u in the rest of a sliver.
  const V along = dot(t.vx, t.vy, t.vz, t.ux, t.uy, t.uz);
  t.vx -= along * t.ux, t.vy -= along * t.uy, t.vz -= along * t.uz;
  const V scale = 1 / squareRoot(dot(t.vx, t.vy, t.vz, t.vx, t.vy, t.vz));
  t.vx *= scale, t.vy *= scale, t.vz *= scale;
  t.nx = t.uy * t.vz - t.uz * t.vy;
  t.ny = t.uz * t.vx - t.ux * t.vz;
  t.nz = t.ux * t.vy - t.uy * t.vx;
  const V e = t.c - t.b;
  t.perC = reciprocal(t.c * t.c + t.d * t.d);
  t.perD = reciprocal(e * e + t.d * t.d);
  return t;
}

/// The vector from the nearest point of a triangle to a position, in the triangle's frame.
template <class V>
struct Away {
  V x, y, z;
  V squared;
};

/// @param T  V, or its scalar type
template <class V, class T>
inline Away<V> awayFrom(const Triangle<T>& t, V px, V py, V pz) {
  const V zero = {}, one = zero + 1;
  const V rx = px - t.ax, ry = py - t.ay, rz = pz - t.az;
  const V x = rx * t.ux + ry * t.uy + rz * t.uz;
  const V y = rx * t.vx + ry * t.vy + rz * t.vz;
  const V z = rx * t.nx + ry * t.ny + rz * t.nz;
  const auto clamp01 = [&](V s) { return lesser(greater(s, zero), one); };
  // The edge from a to b u.
  V ex = x - lesser(greater(x, zero), zero + t.b), ey = y;
  V least = ex * ex + ey * ey;
  const auto meet = [&](V dx, V dy) {
    const V squared = dx * dx + dy * dy;
    const auto nearer = squared < least;
    least = nearer ? squared : least;
    ex = nearer ? dx : ex;
    ey = nearer ? dy : ey;
  };
  // From a to c u + d v.
  const V s = clamp01((x * t.c + y * t.d) * t.perC);
  meet(x - s * t.c, y - s * t.d);
  // From b u to c u + d v.
  const V w = x - t.b;
  const T e = t.c - t.b;
  const V r = clamp01((w * e + y * t.d) * t.perD);
  meet(w - r * e, y - r * t.d);
  const auto inside = (y >= zero) & (t.c * y <= t.d * x) & (e * y >= t.d * w) & (zero + t.d > zero);
  ex = inside ? zero : ex;
  ey = inside ? zero : ey;
  least = inside ? zero : least;
  return {ex, ey, z, least + z * z};
}

/// The triangles of a pack relative to a position, from lane @a first on.
template <class V>
inline Triangle<V> trianglesOf(const TrianglePack& pack, unsigned first, const double position[3]) {
  V at[3][3];
  for (int axis = 0; axis < 3; ++axis)
    for (int c = 0; c < 3; ++c) at[c][axis] = load<V>(pack.corner[c][axis] + first);
  float shift[3];
  for (int axis = 0; axis < 3; ++axis) shift[axis] = static_cast<float>(pack.origin[axis] - position[axis]);
  return frameOf<V>(at[0][0] + shift[0], at[0][1] + shift[1], at[0][2] + shift[2], at[1][0] - at[0][0],
                    at[1][1] - at[0][1], at[1][2] - at[0][2], at[2][0] - at[0][0], at[2][1] - at[0][1],
                    at[2][2] - at[0][2]);
}

}  // namespace
}  // namespace vdbtools::kernels
