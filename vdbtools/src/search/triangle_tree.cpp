// SPDX-License-Identifier: Apache-2.0
#include "search/triangle_tree.h"

#include "julia/instruction_set.h"
#include "search/triangle_point.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <new>
#include <utility>

namespace vdbtools {

const kernels::Kernels& kernels::chosen() {
#ifdef VDBTOOLS_X86_KERNELS
  switch (julia::instructionSet()) {
    case julia::InstructionSet::Avx512: return kAvx512;
    case julia::InstructionSet::Avx2: return kAvx2;
    case julia::InstructionSet::Portable: break;
  }
#endif
  return kPortable;
}

void kernels::setCentre(TreeView& tree, const double (&centre)[3], double longestSide) {
  std::copy(std::begin(centre), std::end(centre), tree.centre);
  // Covers coordinates up to half the longest side, and positions as far away again.
  tree.boxSlack = 1e-5F + 4e-7F * static_cast<float>(longestSide);
}

namespace {

using kernels::kFarAway;
using kernels::kPack;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::Vec3d;
using openvdb::Vec3I;

constexpr std::align_val_t kAlignment{64};

/// Spreads the lowest 21 bits to every third bit.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x001f00000000ffffULL;
  x = (x | x << 16) & 0x001f0000ff0000ffULL;
  x = (x | x << 8) & 0x100f00f00f00f00fULL;
  x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
  return (x | x << 2) & 0x1249249249249249ULL;
}

template <class Body>
void forAll(std::size_t count, std::size_t grain, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

/// The triangles sorted along the curve.
std::vector<std::uint32_t> ordered(const std::vector<Vec3d>& points, const std::vector<Vec3I>& triangles,
                                   const BBoxd& box) {
  constexpr double kCells = 2097152;  // 2^21 along the longest side
  const Vec3d sides = box.extents();
  const double longest = std::max({sides[0], sides[1], sides[2]}), scale = longest > 0 ? kCells / longest : 0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(triangles.size());
  forAll(keys.size(), 4096, [&](std::size_t i) {
    const Vec3I& t = triangles[i];
    const Vec3d middle = (points[t[0]] + points[t[1]] + points[t[2]]) / 3.0;
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::clamp((middle[axis] - box.min()[axis]) * scale, 0.0, kCells - 1);
      key |= spread(static_cast<std::uint64_t>(cell)) << (2 - axis);
    }
    keys[i] = {key, static_cast<std::uint32_t>(i)};
  });
  tbb::parallel_sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(keys.size());
  forAll(keys.size(), 4096, [&](std::size_t i) { order[i] = keys[i].second; });
  return order;
}

/// A box whose bounds are rounded outwards.
struct Box {
  std::array<float, 3> low{kFarAway, kFarAway, kFarAway}, high{-kFarAway, -kFarAway, -kFarAway};

  void expand(const Box& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
  }
};

kernels::BoxNode nodeOf(const std::vector<Box>& boxes, std::size_t first) {
  kernels::BoxNode node;
  for (unsigned k = 0; k < kPack; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool exists = first + k < boxes.size();
      node.low[axis][k] = exists ? boxes[first + k].low[axis] : kFarAway;
      node.high[axis][k] = exists ? boxes[first + k].high[axis] : kFarAway;
    }
  return node;
}

}  // namespace

TriangleTree::TriangleTree(const std::vector<Vec3d>& givenPoints, const std::vector<Vec3I>& triangles,
                           std::optional<Vec3d> about, Frames frames)
    : mPoints(givenPoints), mTriangles(triangles) {
  for (const Vec3I& t : triangles)
    for (int c = 0; c < 3; ++c) mBox.expand(mPoints[t[c]]);
  // Near the origin, doubles are more precise.
  mOrigin = originNear(about.value_or(mBox.getCenter()));
  if (mOrigin != Coord(0)) {
    mMoved.resize(mPoints.size());
    forAll(mMoved.size(), 4096, [&](std::size_t i) { mMoved[i] = mPoints[i] - mOrigin.asVec3d(); });
  }
  const std::vector<Vec3d>& points = localPoints();
  const BBoxd box(mBox.min() - mOrigin.asVec3d(), mBox.max() - mOrigin.asVec3d());
  const Vec3d centre = box.getCenter(), sides = box.extents();
  const std::vector<std::uint32_t> order = ordered(points, triangles, box);

  mPacks.resize((order.size() + kPack - 1) / kPack);
  mNumbers.resize(mPacks.size());
  std::vector<Box> boxes(mPacks.size());
  forAll(mPacks.size(), 512, [&](std::size_t p) {
    kernels::TrianglePack& pack = mPacks[p];
    BBoxd around;
    for (unsigned k = 0; k < kPack; ++k) {
      const std::size_t at = kPack * p + k < order.size() ? kPack * p + k : kPack * p;
      mNumbers[p].triangle[k] = order[at];
      for (int c = 0; c < 3; ++c) around.expand(points[triangles[order[at]][c]]);
    }
    const Vec3d origin = around.getCenter();
    for (int axis = 0; axis < 3; ++axis) {
      pack.origin[axis] = origin[axis];
      const auto i = static_cast<std::size_t>(axis);
      boxes[p].low[i] = static_cast<float>(around.min()[axis] - centre[axis]);
      boxes[p].high[i] = static_cast<float>(around.max()[axis] - centre[axis]);
    }
    for (unsigned k = 0; k < kPack; ++k)
      for (int c = 0; c < 3; ++c)
        for (int axis = 0; axis < 3; ++axis)
          pack.corner[c][axis][k] =
              static_cast<float>(points[triangles[mNumbers[p].triangle[k]][c]][axis] - origin[axis]);
  });
  do {
    std::vector<kernels::BoxNode> level((boxes.size() + kPack - 1) / kPack);
    std::vector<Box> above(level.size());
    for (std::size_t i = 0; i < level.size(); ++i) {
      level[i] = nodeOf(boxes, kPack * i);
      for (std::size_t k = kPack * i; k < std::min(kPack * (i + 1), boxes.size()); ++k) above[i].expand(boxes[k]);
    }
    mLevels.push_back(std::move(level));
    boxes = std::move(above);
  } while (boxes.size() > 1);

  mView.packs = mPacks.data();
  mView.numbers = mNumbers.data();
  for (std::size_t l = 0; l < mLevels.size(); ++l) mView.levels[l] = mLevels[l].data();
  mView.levelCount = static_cast<unsigned>(mLevels.size());
  kernels::setCentre(mView, {centre[0], centre[1], centre[2]}, std::max({sides[0], sides[1], sides[2]}));
  static_assert(sizeof(Vec3d) == 3 * sizeof(double) && sizeof(Vec3I) == 3 * sizeof(std::uint32_t));
  mView.points = points.front().asPointer();
  mView.triangles = triangles.front().asPointer();
  if (frames == Frames::ForEachBlock) return;
  mFrames.resize(mPacks.size());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(mFrames.size()), 512),
                    [&](const auto& range) {
                      kernels::chosen().makeFrames(mView, range.begin(), range.end() - range.begin(), mFrames.data());
                    });
  mView.frames = mFrames.data();
}

Coord TriangleTree::originNear(const Vec3d& position) {
  Coord origin;
  for (int axis = 0; axis < 3; ++axis)
    origin[axis] = kOriginStep * static_cast<int>(std::lround(position[axis] / kOriginStep));
  return origin;
}

std::optional<TriangleTree::Nearest> TriangleTree::nearest(const Vec3d& position, double within) const {
  // Slightly farther, because floats choose.
  const double reach = within * 1.00001 + 2 * double{mView.boxSlack};
  auto squared = static_cast<float>(std::min(reach * reach, 1e30));
  kernels::Place place{};
  const Vec3d local = position - mOrigin.asVec3d();
  if (!kernels::chosen().nearest(mView, local.asPointer(), kernels::kNoPack, squared, place)) return std::nullopt;
  const std::uint32_t triangle = mNumbers[place.pack].triangle[place.lane];
  const Vec3I& t = mTriangles[triangle];
  const std::vector<Vec3d>& points = localPoints();
  Vec3d weights;
  const Vec3d point = nearestOnTriangle(points[t[0]], points[t[1]], points[t[2]], local, weights);
  const double distance = (point - local).length();
  if (!(distance <= within)) return std::nullopt;
  return Nearest{triangle, point + mOrigin.asVec3d(), distance};
}

BlockDistances::BlockDistances(const TriangleTree& tree) : mView(tree.mView), mOrigin(tree.mOrigin), mPacks(256) {
  reserve(256);
}

BlockDistances::BlockDistances(const TriangleBins& bins) : mView(bins.view()), mOrigin(bins.origin()), mPacks(256) {
  reserve(256);
}

void BlockDistances::Release::operator()(void* memory) const { ::operator delete(memory, kAlignment); }

void BlockDistances::reserve(std::uint32_t packs) {
  if (packs <= mScratch.capacity) return;
  constexpr std::uint32_t kRound = 16;  // plus one vector in each array
  const std::uint32_t capacity = (std::max(packs, 2 * mScratch.capacity) + kRound - 1) / kRound * kRound;
  const std::size_t room = capacity + kRound;
  const std::size_t sizes[] = {room * kernels::kCandidateBytes, room * kernels::kCandidateBytes,
                               room * kernels::kFoundBytes, room * kernels::kBoxBytes};
  mMemory.reset(::operator new(sizes[0] + sizes[1] + sizes[2] + sizes[3], kAlignment));
  auto* memory = static_cast<std::byte*>(mMemory.get());
  mScratch.candidates[0] = memory;
  mScratch.candidates[1] = memory += sizes[0];
  mScratch.found = memory += sizes[1];
  mScratch.boxes = memory += sizes[2];
  mLists.assign(2 * kPack * room, 0);
  mScratch.list[0] = mLists.data();
  mScratch.list[1] = mLists.data() + kPack * room;
  mScratch.capacity = capacity;
}

std::optional<float> BlockDistances::distance(const Vec3d& position, float within) {
  float squared = within * within;
  const Vec3d local = position - mOrigin.asVec3d();
  if (!kernels::chosen().nearest(mView, local.asPointer(), mLast.pack, squared, mLast)) return std::nullopt;
  mLastAt = local;
  return std::sqrt(squared);
}

namespace {

constexpr double kMiddle = 0.5 * (BlockDistances::kSide - 1);

/// Calls find(packs, capacity), and once more if there are more packs than room.
template <class Find>
std::uint32_t packsBy(std::vector<std::uint32_t>& packs, const Find& find) {
  const std::uint32_t count = find(packs.data(), static_cast<std::uint32_t>(packs.size()));
  if (count <= packs.size()) return count;
  packs.resize(2 * std::size_t{count});
  return find(packs.data(), static_cast<std::uint32_t>(packs.size()));
}

}  // namespace

Vec3d BlockDistances::middleOf(const Coord& origin) const { return (origin - mOrigin).asVec3d() + Vec3d(kMiddle); }

void BlockDistances::resolve(const Vec3d& middle, std::uint32_t packs, float far) {
  std::fill(std::begin(mDistances), std::end(mDistances), std::numeric_limits<float>::infinity());
  reserve(packs);
  kernels::chosen().resolve(mView, middle.asPointer(), mPacks.data(), packs, far, mScratch, mDistances, mTriangles);
}

void BlockDistances::evaluate(const Coord& origin, float far) {
  const Vec3d middle = middleOf(origin);
  if (mLastAt != middle) {
    float squared = 1e30F;
    kernels::chosen().nearest(mView, middle.asPointer(), mLast.pack, squared, mLast);
    mLastAt = middle;
  }
  const std::uint32_t count = packsBy(mPacks, [&](std::uint32_t* packs, std::uint32_t capacity) {
    return kernels::chosen().collect(mView, middle.asPointer(), kMiddle, mLast, packs, capacity);
  });
  resolve(middle, count, far);
}

bool BlockDistances::evaluate(const Coord& origin, float far, std::span<const std::uint32_t> nodes) {
  const Vec3d middle = middleOf(origin);
  const std::uint32_t count = packsBy(mPacks, [&](std::uint32_t* packs, std::uint32_t capacity) {
    return kernels::chosen().gather(mView, middle.asPointer(), kMiddle, far, nodes.data(),
                                    static_cast<std::uint32_t>(nodes.size()), packs, capacity);
  });
  if (count == 0) return false;
  resolve(middle, count, far);
  return true;
}

}  // namespace vdbtools
