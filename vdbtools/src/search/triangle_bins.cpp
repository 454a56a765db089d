// SPDX-License-Identifier: Apache-2.0
#include "search/triangle_bins.h"

#include "base/in_parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace vdbtools {
namespace {

using kernels::kFarAway;
using kernels::kPack;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::Vec3d;
using openvdb::Vec3I;

std::uint32_t packsOf(std::size_t triangles) { return static_cast<std::uint32_t>((triangles + kPack - 1) / kPack); }
std::uint32_t nodesOf(std::size_t triangles) { return (packsOf(triangles) + kPack - 1) / kPack; }

/// The cubes of 2^3 cells of a block, along a curve (G. M. Morton, 1966).
constexpr unsigned kCubes = 64;

unsigned cubeOf(const Vec3d& middle, const Coord& block) {
  unsigned cube = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<unsigned>(std::clamp(static_cast<int>(middle[axis] - block[axis]) / 2, 0, 3));
    cube |= ((at & 1) | (at & 2) << 2) << (2 - axis);
  }
  return cube;
}

}  // namespace

TriangleBins::TriangleBins(const Coord& origin, const openvdb::CoordBBox& nodes) : mOrigin(origin) {
  const Vec3d centre = nodes.getCenter() - origin.asVec3d();
  kernels::setCentre(mView, {centre[0], centre[1], centre[2]}, nodes.dim()[static_cast<int>(nodes.maxExtent())]);
  mView.levelCount = 1;
}

std::vector<TriangleBins::Bin> TriangleBins::add(std::span<const Coord> blocks,
                                                 std::span<const std::vector<Vec3I>* const> triangles,
                                                 const Points& points, const Monitor& monitor) {
  std::vector<Bin> bins(blocks.size());
  std::vector<std::uint32_t> firsts(blocks.size());
  std::uint32_t triangleEnd = triangleCount(), nodeEnd = nodeCount();
  for (std::size_t i = 0; i < bins.size(); ++i) {
    firsts[i] = triangleEnd;
    bins[i] = {nodeEnd, nodesOf(triangles[i]->size())};
    triangleEnd += static_cast<std::uint32_t>(triangles[i]->size());
    nodeEnd += bins[i].count;
  }
  mCorners.resize(3 * std::size_t{triangleEnd});
  mNumbers.resize(kPack * std::size_t{nodeEnd});
  mFrames.resize(mNumbers.size());
  mBoxes.resize(nodeEnd);
  if (mOwn.size() < mCorners.size()) {
    mOwn.resize(mCorners.size());
    std::iota(mOwn.begin(), mOwn.end(), 0U);
  }
  setView();
  inParallel(bins.size(), 16, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      fill(blocks[i], *triangles[i], points, firsts[i], bins[i]);
      kernels::chosen().makeFrames(mView, kPack * bins[i].first, packsOf(triangles[i]->size()), mFrames.data());
    }
  });
  return bins;
}

void TriangleBins::fill(const Coord& block, const std::vector<Vec3I>& triangles, const Points& points,
                        std::uint32_t firstTriangle, const Bin& bin) {
  Vec3d* const corners = mCorners.data() + 3 * std::size_t{firstTriangle};
  const Coord local = block - mOrigin;
  std::vector<std::uint8_t> cubes(triangles.size());
  std::array<std::uint32_t, kCubes + 1> begins{};
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) corners[3 * t + c] = points[triangles[t][static_cast<int>(c)]];
    cubes[t] = static_cast<std::uint8_t>(cubeOf((corners[3 * t] + corners[3 * t + 1] + corners[3 * t + 2]) / 3, local));
    ++begins[cubes[t] + 1];
  }
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<std::uint32_t> order(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) order[begins[cubes[t]]++] = static_cast<std::uint32_t>(t);

  for (std::uint32_t pack = 0; pack < kPack * bin.count; ++pack) {
    kernels::BoxNode& box = mBoxes[bin.first + pack / kPack];
    const unsigned lane = pack % kPack;
    if (kPack * std::size_t{pack} >= order.size()) {
      for (int axis = 0; axis < 3; ++axis) box.low[axis][lane] = box.high[axis][lane] = kFarAway;
      continue;
    }
    kernels::PackNumbers& numbers = mNumbers[kPack * std::size_t{bin.first} + pack];
    BBoxd around;
    for (unsigned k = 0; k < kPack; ++k) {
      const std::size_t at = kPack * std::size_t{pack} + k;
      const std::uint32_t t = order[at < order.size() ? at : kPack * std::size_t{pack}];
      numbers.triangle[k] = firstTriangle + t;
      for (std::size_t c = 0; c < 3; ++c) around.expand(corners[3 * std::size_t{t} + c]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis][lane] = static_cast<float>(around.min()[axis] - mView.centre[axis]);
      box.high[axis][lane] = static_cast<float>(around.max()[axis] - mView.centre[axis]);
    }
  }
}

void TriangleBins::removeFirst(std::uint32_t triangles, std::uint32_t nodes) {
  const auto eraseFirst = [](auto& values, std::size_t count) {
    values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
  };
  eraseFirst(mCorners, 3 * std::size_t{triangles});
  eraseFirst(mNumbers, kPack * std::size_t{nodes});
  eraseFirst(mFrames, kPack * std::size_t{nodes});
  eraseFirst(mBoxes, nodes);
  for (kernels::PackNumbers& numbers : mNumbers)
    for (std::uint32_t& number : numbers.triangle) number -= triangles;
  setView();
}

void TriangleBins::setView() {
  static_assert(sizeof(Vec3d) == 3 * sizeof(double));
  mView.numbers = mNumbers.data();
  mView.frames = mFrames.data();
  mView.levels[0] = mBoxes.data();
  mView.points = mCorners.empty() ? nullptr : mCorners.front().asPointer();
  mView.triangles = mOwn.data();
}

}  // namespace vdbtools
