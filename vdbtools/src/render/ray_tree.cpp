// SPDX-License-Identifier: Apache-2.0
#include "render/ray_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

constexpr double kFarAway = 1e9;       ///< farther than any hit: the triangles lie around the origin, the eye near them
constexpr float kNowhere = 1e30f;      ///< position of missing boxes
constexpr double kLeastSlope = 1e-20;  ///< of a direction component, so that its reciprocal is finite

/// The position on a Hilbert curve of a cube of 2^20 cells along each side (J. Skilling, "Programming the Hilbert
/// curve", 2004).
std::uint64_t hilbertPlace(std::array<std::uint32_t, 3> x) {
  constexpr int kBits = 20;
  for (std::uint32_t bit = 1u << (kBits - 1); bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (std::uint32_t& coordinate : x) {
      if (coordinate & bit) {
        x[0] ^= below;
      } else {
        const std::uint32_t swapped = (x[0] ^ coordinate) & below;
        x[0] ^= swapped;
        coordinate ^= swapped;
      }
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t turns = 0;
  for (std::uint32_t bit = 1u << (kBits - 1); bit > 1; bit >>= 1)
    if (x[2] & bit) turns ^= bit - 1;
  std::uint64_t place = 0;
  for (int bit = kBits - 1; bit >= 0; --bit)
    for (const std::uint32_t coordinate : x) place = place << 1 | (((coordinate ^ turns) >> bit) & 1);
  return place;
}

std::uint64_t placeOf(const Vec3s& a, const Vec3s& b, const Vec3s& c) {
  constexpr float kCells = 1 << 20;
  std::array<std::uint32_t, 3> cell;
  for (int axis = 0; axis < 3; ++axis) {
    const float middle = (a[axis] + b[axis] + c[axis]) / 3;
    cell[static_cast<std::size_t>(axis)] =
        static_cast<std::uint32_t>(std::clamp((middle + 1) * (kCells / 2), 0.0f, kCells - 1));
  }
  return hilbertPlace(cell);
}

template <class Body>
void forEach(std::size_t count, const Monitor& monitor, const Body& body) {
  constexpr std::size_t kGrain = 4096;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      monitor.throwIfCancelled();
                      for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
                    });
}

}  // namespace

struct RayTree::Ray {
  Vec3d origin, direction;
  float from[3], along[3], inverse[3];

  Ray(const Vec3d& o, const Vec3d& d) : origin(o), direction(d) {
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = static_cast<float>(o[axis]);
      along[axis] = static_cast<float>(d[axis]);
      inverse[axis] =
          static_cast<float>(1 / (std::abs(d[axis]) < kLeastSlope ? std::copysign(kLeastSlope, d[axis]) : d[axis]));
    }
  }
};

RayTree::RayTree(const std::vector<Vec3s>& points, const std::vector<Vec3I>& triangles, Monitor& monitor) {
  monitor.begin(PhaseKind::RayTree, 0);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(triangles.size());
  forEach(order.size(), monitor, [&](std::size_t i) {
    const Vec3I& t = triangles[i];
    order[i] = {placeOf(points[t[0]], points[t[1]], points[t[2]]), static_cast<std::uint32_t>(i)};
  });
  tbb::parallel_sort(order.begin(), order.end());
  monitor.throwIfCancelled();

  const auto nodes = [](std::size_t children) { return (children + kChildren - 1) / kChildren; };
  Node nothing;
  for (int axis = 0; axis < 3; ++axis)
    for (std::uint32_t i = 0; i < kChildren; ++i) nothing.low[axis][i] = nothing.high[axis][i] = kNowhere;
  mPacks.assign((order.size() + kLanes - 1) / kLanes, Pack{});
  mLevels.emplace_back(nodes(mPacks.size()), nothing);
  forEach(mPacks.size(), monitor, [&](std::size_t p) {
    Pack& pack = mPacks[p];
    Vec3s low(kNowhere), high(-kNowhere);
    for (std::size_t lane = 0; lane < kLanes && p * kLanes + lane < order.size(); ++lane) {
      pack.triangles[lane] = order[p * kLanes + lane].second;
      const Vec3I& t = triangles[pack.triangles[lane]];
      const Vec3s &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
      for (int axis = 0; axis < 3; ++axis) {
        pack.corner[axis][lane] = a[axis];
        pack.second[axis][lane] = b[axis] - a[axis];
        pack.third[axis][lane] = c[axis] - a[axis];
        low[axis] = std::min({low[axis], a[axis], b[axis], c[axis]});
        high[axis] = std::max({high[axis], a[axis], b[axis], c[axis]});
      }
    }
    // Slack for the rounding of the ray, and of the distances to a box's faces.
    constexpr float kRoom = 1e-6f;
    Node& node = mLevels[0][p / kChildren];
    for (int axis = 0; axis < 3; ++axis) {
      node.low[axis][p % kChildren] = low[axis] - kRoom;
      node.high[axis][p % kChildren] = high[axis] + kRoom;
    }
  });
  while (mLevels.back().size() > 1) {
    const std::vector<Node>& children = mLevels.back();
    std::vector<Node> level(nodes(children.size()), nothing);
    forEach(children.size(), monitor, [&](std::size_t c) {
      for (int axis = 0; axis < 3; ++axis) {
        float low = kNowhere, high = -kNowhere;
        for (std::uint32_t i = 0; i < kChildren && children[c].low[axis][i] < kNowhere; ++i) {
          low = std::min(low, children[c].low[axis][i]);
          high = std::max(high, children[c].high[axis][i]);
        }
        level[c / kChildren].low[axis][c % kChildren] = low;
        level[c / kChildren].high[axis][c % kChildren] = high;
      }
    });
    mLevels.push_back(std::move(level));
  }
}

/// T. Moeller and B. Trumbore, "Fast, minimum storage ray-triangle intersection", 1997: four triangles in floats with
/// some tolerance, and possible hits again in doubles.
template <bool Any>
bool RayTree::meets(const Pack& pack, const Ray& ray, Hit& hit) {
  constexpr float kLoose = 1e-3f, kOriginRounding = 1e-6f;
  constexpr double kTight = 1e-6;  // tolerance, so that rays do not slip through between two triangles
  const float nearest = static_cast<float>(hit.distance) * 1.0001f + 1e-6f;
  float may[kLanes];
  for (std::uint32_t i = 0; i < kLanes; ++i) {
    const float px = ray.along[1] * pack.third[2][i] - ray.along[2] * pack.third[1][i];
    const float py = ray.along[2] * pack.third[0][i] - ray.along[0] * pack.third[2][i];
    const float pz = ray.along[0] * pack.third[1][i] - ray.along[1] * pack.third[0][i];
    const float determinant = pack.second[0][i] * px + pack.second[1][i] * py + pack.second[2][i] * pz;
    const float inverse = 1 / determinant;
    const float sx = ray.from[0] - pack.corner[0][i], sy = ray.from[1] - pack.corner[1][i],
                sz = ray.from[2] - pack.corner[2][i];
    const float u = (sx * px + sy * py + sz * pz) * inverse;
    const float qx = sy * pack.second[2][i] - sz * pack.second[1][i];
    const float qy = sz * pack.second[0][i] - sx * pack.second[2][i];
    const float qz = sx * pack.second[1][i] - sy * pack.second[0][i];
    const float v = (ray.along[0] * qx + ray.along[1] * qy + ray.along[2] * qz) * inverse;
    const float t = (pack.third[0][i] * qx + pack.third[1][i] * qy + pack.third[2][i] * qz) * inverse;
    const float outside = std::max(std::max(-u, -v), u + v - 1);
    // The effect of the rounding of the ray's origin on u and v.
    const float rounding = kOriginRounding * std::abs(inverse) *
                           (std::abs(px) + std::abs(py) + std::abs(pz) + std::abs(pack.second[0][i]) +
                            std::abs(pack.second[1][i]) + std::abs(pack.second[2][i]));
    // False also if a determinant of 0 has produced a NaN.
    may[i] = ((outside <= kLoose + rounding) & (t >= -1e-3f) & (t <= nearest + 1e-3f)) ? 1.0f : 0.0f;
  }
  bool found = false;
  for (std::uint32_t i = 0; i < kLanes; ++i) {
    if (may[i] == 0.0f) continue;
    const Vec3d second(pack.second[0][i], pack.second[1][i], pack.second[2][i]);
    const Vec3d third(pack.third[0][i], pack.third[1][i], pack.third[2][i]);
    const Vec3d p = ray.direction.cross(third);
    const double inverse = 1 / second.dot(p);
    const Vec3d s = ray.origin - Vec3d(pack.corner[0][i], pack.corner[1][i], pack.corner[2][i]);
    const double u = s.dot(p) * inverse;
    const Vec3d q = s.cross(second);
    const double v = ray.direction.dot(q) * inverse, t = third.dot(q) * inverse;
    if (!(u >= -kTight && v >= -kTight && u + v <= 1 + kTight && t > 0)) continue;
    if constexpr (Any) return true;
    // Ties are broken by the lower number, whatever the order in which boxes are visited.
    if (t > hit.distance || (t == hit.distance && pack.triangles[i] > hit.triangle)) continue;
    hit = {t, pack.triangles[i], u, v};
    found = true;
  }
  return found;
}

template <bool Any>
bool RayTree::trace(const Ray& ray, Hit& hit) const {
  struct Entry {
    float near;
    std::uint32_t level, index;
  };
  std::array<Entry, kMostLevels * kChildren> stack;
  std::size_t size = 0;
  stack[size++] = {0, static_cast<std::uint32_t>(mLevels.size()), 0};
  bool found = false;
  while (size > 0) {
    const Entry entry = stack[--size];
    if (!Any && static_cast<double>(entry.near) > hit.distance) continue;
    if (entry.level == 0) {
      found = meets<Any>(mPacks[entry.index], ray, hit) || found;
      if (Any && found) return true;
      continue;
    }
    const Node& node = mLevels[entry.level - 1][entry.index];
    const float* enter[3];
    const float* leave[3];
    for (int axis = 0; axis < 3; ++axis) {
      enter[axis] = ray.inverse[axis] < 0 ? node.high[axis] : node.low[axis];
      leave[axis] = ray.inverse[axis] < 0 ? node.low[axis] : node.high[axis];
    }
    float near[kChildren], far[kChildren];
    const float limit = static_cast<float>(hit.distance) * 1.0001f;
    for (std::uint32_t i = 0; i < kChildren; ++i) {
      const float x = (enter[0][i] - ray.from[0]) * ray.inverse[0], y = (enter[1][i] - ray.from[1]) * ray.inverse[1],
                  z = (enter[2][i] - ray.from[2]) * ray.inverse[2];
      near[i] = std::max(std::max(x, y), std::max(z, 0.0f));
    }
    for (std::uint32_t i = 0; i < kChildren; ++i) {
      const float x = (leave[0][i] - ray.from[0]) * ray.inverse[0], y = (leave[1][i] - ray.from[1]) * ray.inverse[1],
                  z = (leave[2][i] - ray.from[2]) * ray.inverse[2];
      far[i] = std::min(std::min(x, y), std::min(z, limit));
    }
    const std::size_t first = size;
    for (std::uint32_t i = 0; i < kChildren; ++i) {
      // A slack of a few ulp (T. Ize, "Robust BVH ray traversal", 2013).
      if (!(near[i] <= far[i] * 1.000001f)) continue;
      std::size_t at = size++;
      if constexpr (!Any)
        for (; at > first && stack[at - 1].near < near[i]; --at) stack[at] = stack[at - 1];
      stack[at] = {near[i], entry.level - 1, entry.index * kChildren + i};
    }
  }
  return found;
}

std::optional<RayTree::Hit> RayTree::firstHit(const Vec3d& origin, const Vec3d& direction) const {
  // Starts near the triangles, where floats are precise.
  constexpr double kBefore = 2;
  const double start = std::max(0.0, -origin.dot(direction) / direction.lengthSqr() - kBefore / direction.length());
  Hit hit{.distance = kFarAway};
  if (!trace<false>(Ray(origin + start * direction, direction), hit)) return std::nullopt;
  hit.distance += start;
  return hit;
}

bool RayTree::blocked(const Vec3d& origin, const Vec3d& direction) const {
  Hit hit{.distance = kFarAway};
  return trace<true>(Ray(origin, direction), hit);
}

}  // namespace vdbtools
