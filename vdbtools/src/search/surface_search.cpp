// SPDX-License-Identifier: Apache-2.0
#include "search/surface_search.h"

#include "search/triangle_point.h"

#include <openvdb/math/Proximity.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

constexpr std::uint32_t kLeaf = 4;  ///< triangles examined one by one

/// Halving 2^32 triangles makes a tree of this depth.
constexpr std::size_t kMostDepth = 40;

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

}  // namespace

double SurfaceSearch::Box::distanceSquared(const Vec3d& p) const {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = p[static_cast<int>(axis)];
    const double d = std::max({low[axis] - x, x - high[axis], 0.0});
    sum += d * d;
  }
  return sum;
}

SurfaceSearch::SurfaceSearch(std::vector<Vec3d> points, std::vector<openvdb::Vec3I> triangles)
    : mPoints(std::move(points)), mTriangles(std::move(triangles)), mOrder(mTriangles.size()) {
  std::iota(mOrder.begin(), mOrder.end(), 0U);
  std::vector<Vec3d> middles;
  middles.reserve(mTriangles.size());
  mThin.reserve(mTriangles.size());
  for (const openvdb::Vec3I& t : mTriangles) {
    middles.push_back((mPoints[t[0]] + mPoints[t[1]] + mPoints[t[2]]) / 3.0);
    mThin.push_back(isThin(mPoints[t[0]], mPoints[t[1]], mPoints[t[2]]));
  }
  mNodes.reserve(mTriangles.size());
  if (!mTriangles.empty()) build(0, static_cast<std::uint32_t>(mTriangles.size()), middles);
}

void SurfaceSearch::build(std::uint32_t begin, std::uint32_t end, const std::vector<Vec3d>& middles) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}}, middleBox = box;
  const auto expand = [](Box& some, const Vec3d& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      some.low[axis] = std::min(some.low[axis], p[static_cast<int>(axis)]);
      some.high[axis] = std::max(some.high[axis], p[static_cast<int>(axis)]);
    }
  };
  for (std::uint32_t i = begin; i < end; ++i) {
    const openvdb::Vec3I& t = mTriangles[mOrder[i]];
    for (int c = 0; c < 3; ++c) expand(box, mPoints[t[c]]);
    expand(middleBox, middles[mOrder[i]]);
  }
  const std::size_t node = mNodes.size();
  mNodes.push_back({box, begin, end - begin});
  if (end - begin <= kLeaf) return;
  int axis = 0;
  double widest = -1;
  for (std::size_t a = 0; a < 3; ++a)
    if (const double width = middleBox.high[a] - middleBox.low[a]; width > widest) {
      widest = width;
      axis = static_cast<int>(a);
    }
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(mOrder.begin() + begin, mOrder.begin() + half, mOrder.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(middles[a][axis], a) < std::pair(middles[b][axis], b);
                   });
  build(begin, half, middles);
  mNodes[node].first = static_cast<std::uint32_t>(mNodes.size());
  mNodes[node].count = 0;
  build(half, end, middles);
}

void SurfaceSearch::meet(std::uint32_t triangle, const Vec3d& position, SurfacePoint& best, double& bestSquared) const {
  const openvdb::Vec3I& t = mTriangles[triangle];
  Vec3d weights;
  const auto nearestOf = mThin[triangle] ? nearestOnTriangle : openvdb::math::closestPointOnTriangleToPoint;
  const Vec3d nearest = nearestOf(mPoints[t[0]], mPoints[t[1]], mPoints[t[2]], position, weights);
  const double squared = (nearest - position).lengthSqr();
  if (squared < bestSquared || (squared == bestSquared && triangle < best.triangle)) {
    best = {triangle, weights, 0};
    bestSquared = squared;
  }
}

std::optional<SurfacePoint> SurfaceSearch::nearest(const Vec3d& position, double within,
                                                   std::optional<std::uint32_t> hint) const {
  if (mNodes.empty()) return std::nullopt;
  SurfacePoint best{.triangle = kNobody};
  double bestSquared = within * within;
  if (hint) meet(*hint, position, best, bestSquared);
  struct Entry {
    std::uint32_t node;
    double squared;
  };
  std::array<Entry, kMostDepth + 1> stack;
  std::size_t size = 0;
  stack[size++] = {0, mNodes[0].box.distanceSquared(position)};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.squared > bestSquared) continue;
    const Node& node = mNodes[entry.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) meet(mOrder[i], position, best, bestSquared);
      continue;
    }
    Entry nearer{entry.node + 1, mNodes[entry.node + 1].box.distanceSquared(position)};
    Entry farther{node.first, mNodes[node.first].box.distanceSquared(position)};
    if (farther.squared < nearer.squared) std::swap(nearer, farther);
    stack[size++] = farther;
    stack[size++] = nearer;
  }
  if (best.triangle == kNobody) return std::nullopt;
  best.distance = std::sqrt(bestSquared);
  return best;
}

}  // namespace vdbtools
