// SPDX-License-Identifier: Apache-2.0
#include "distance/triangle_boxes.h"

#include <tbb/parallel_invoke.h>

#include <bit>
#include <numeric>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Vec3d;

constexpr std::size_t kTrianglesOfLeaf = 4;

}  // namespace

TriangleBoxes::TriangleBoxes(const std::vector<Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles)
    : mPoints(points), mTriangles(triangles), mOrder(triangles.size()) {
  std::iota(mOrder.begin(), mOrder.end(), 0U);
  mLeaves = std::bit_ceil(std::max<std::size_t>(1, mOrder.size() / kTrianglesOfLeaf));
  mBoxes.resize(2 * mLeaves);
  arrange(1, 0, mLeaves);
}

BBoxd TriangleBoxes::boxOf(std::uint32_t triangle) const {
  const openvdb::Vec3I& t = mTriangles[triangle];
  BBoxd box(mPoints[t[0]], mPoints[t[0]]);
  box.expand(mPoints[t[1]]);
  box.expand(mPoints[t[2]]);
  return box;
}

void TriangleBoxes::arrange(std::size_t node, std::size_t firstLeaf, std::size_t leaves) {
  const auto begin = mOrder.begin() + static_cast<std::ptrdiff_t>(firstOf(firstLeaf)),
             end = mOrder.begin() + static_cast<std::ptrdiff_t>(firstOf(firstLeaf + leaves));
  if (leaves == 1) {
    for (auto triangle = begin; triangle != end; ++triangle) mBoxes[node].expand(boxOf(*triangle));
    return;
  }
  const auto twiceMiddle = [this](std::uint32_t triangle, int axis) {
    const BBoxd box = boxOf(triangle);
    return box.min()[axis] + box.max()[axis];
  };
  BBoxd middles;
  for (auto triangle = begin; triangle != end; ++triangle) {
    const BBoxd box = boxOf(*triangle);
    middles.expand(box.min() + box.max());
  }
  const auto axis = static_cast<int>(middles.maxExtent());
  const auto half = mOrder.begin() + static_cast<std::ptrdiff_t>(firstOf(firstLeaf + leaves / 2));
  // Ties are broken by number, so that the order does not depend on the library.
  if (half != end)
    std::nth_element(begin, half, end, [&](std::uint32_t a, std::uint32_t b) {
      const double x = twiceMiddle(a, axis), y = twiceMiddle(b, axis);
      return x < y || (x == y && a < b);
    });
  const auto first = [&] { arrange(2 * node, firstLeaf, leaves / 2); };
  const auto second = [&] { arrange(2 * node + 1, firstLeaf + leaves / 2, leaves / 2); };
  constexpr std::ptrdiff_t kForThreads = 4096;
  if (end - begin > kForThreads) {
    tbb::parallel_invoke(first, second);
  } else {
    first();
    second();
  }
  mBoxes[node] = mBoxes[2 * node];
  mBoxes[node].expand(mBoxes[2 * node + 1]);
}

}  // namespace vdbtools
