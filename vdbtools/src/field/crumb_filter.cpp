// SPDX-License-Identifier: Apache-2.0
#include "field/crumb_filter.h"

#include "base/in_parallel.h"
#include "field/block_layers.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

namespace vdbtools {

using openvdb::Coord;
using openvdb::CoordBBox;

namespace {

static_assert(kCrumb <= kBlock, "a crumb must lie in a block and those next to it");

// Masks for a word of InsideBits: the nodes of its first and last rows along y, and the first and last along z in all
// rows.
constexpr std::uint64_t kFirstY = 0xff, kLastY = kFirstY << 56;
constexpr std::uint64_t kFirstZ = 0x0101010101010101, kLastZ = kFirstZ << 7;

/// The nodes of a word that are connected to some of its nodes through nodes of @a within.
std::uint64_t filled(std::uint64_t word, std::uint64_t within) {
  for (;;) {
    const std::uint64_t before = word;
    // Fills in each direction along z, then along y, as far as possible.
    std::uint64_t way = within & ~kFirstZ;
    for (int step = 1; step < kBlock; step *= 2) {
      word |= way & word << step;
      way &= way << step;
    }
    way = within & ~kLastZ;
    for (int step = 1; step < kBlock; step *= 2) {
      word |= way & word >> step;
      way &= way >> step;
    }
    way = within;
    for (int step = kBlock; step < kBlock * kBlock; step *= 2) {
      word |= way & word << step;
      way &= way << step;
    }
    way = within;
    for (int step = kBlock; step < kBlock * kBlock; step *= 2) {
      word |= way & word >> step;
      way &= way >> step;
    }
    if (word == before) return word;
  }
}

/// The nodes of a block that are connected to the first one of @a within, inside the block.
InsideBits firstPart(const InsideBits& within) {
  InsideBits part{};
  std::size_t first = 0;
  while (within[first] == 0) ++first;
  part[first] = filled(within[first] & (~within[first] + 1), within[first]);
  for (bool grew = true; grew;) {
    grew = false;
    const auto grow = [&](std::size_t x, std::size_t from) {
      const std::uint64_t more = part[from] & within[x] & ~part[x];
      if (more == 0) return;
      part[x] = filled(part[x] | more, within[x]);
      grew = true;
    };
    for (std::size_t x = 1; x < kBlock; ++x) grow(x, x - 1);
    for (std::size_t x = kBlock - 1; x-- > 0;) grow(x, x + 1);
  }
  return part;
}

/// The bounding box of a non-empty set of nodes of a block with this first node.
CoordBBox boxOf(const InsideBits& nodes, const Coord& origin) {
  std::uint64_t all = 0;
  int low = kBlock, high = 0;
  for (int x = 0; x < kBlock; ++x) {
    const std::uint64_t word = nodes[static_cast<std::size_t>(x)];
    if (word == 0) continue;
    all |= word;
    low = std::min(low, x);
    high = x;
  }
  std::uint64_t row = 0;
  for (int y = 0; y < kBlock; ++y) row |= all >> (kBlock * y) & kFirstY;
  const Coord first(low, std::countr_zero(all) / kBlock, std::countr_zero(row));
  const Coord last(high, (63 - std::countl_zero(all)) / kBlock, 63 - std::countl_zero(row));
  return {origin + first, origin + last};
}

int longestSide(const CoordBBox& box) {
  const Coord sides = box.dim();
  return std::max({sides[0], sides[1], sides[2]});
}

/// Calls body(offset) for the nodes of a block, in the order of (x, y, z).
template <class Body>
void forEachNode(const InsideBits& nodes, const Body& body) {
  for (std::size_t x = 0; x < kBlock; ++x)
    for (std::uint64_t rest = nodes[x]; rest != 0; rest &= rest - 1)
      body(static_cast<openvdb::Index>(64 * x + static_cast<std::size_t>(std::countr_zero(rest))));
}

Coord nodeAt(const Coord& origin, openvdb::Index offset) {
  return origin + CrumbFilter::Leaf::offsetToLocalCoord(offset);
}

/// Whether two blocks that touch across a face along @a axis have adjacent inside nodes there.
/// @param far  the block on the positive side
bool touch(const InsideBits& near, const InsideBits& far, int axis) {
  if (axis == 0) return (near[kBlock - 1] & far[0]) != 0;
  for (std::size_t x = 0; x < kBlock; ++x)
    if (axis == 1 ? (near[x] & kLastY) >> 56 & far[x] : (near[x] & kLastZ) >> 7 & far[x] & kFirstZ) return true;
  return false;
}

}  // namespace

/// A layer and its signs.
struct CrumbFilter::Signs {
  int x = 0;
  Layer layer;
  std::vector<std::pair<int, int>> places;  ///< y and z of the leaves
  std::vector<InsideBits> bits;             ///< signs of the leaves

  const InsideBits* find(int y, int z) const {
    const auto at = std::lower_bound(places.begin(), places.end(), std::pair(y, z));
    return at != places.end() && *at == std::pair(y, z) ? &bits[static_cast<std::size_t>(at - places.begin())]
                                                        : nullptr;
  }
};

/// A block and those next to it, each looked up only once.
class CrumbFilter::Neighbourhood {
 public:
  Neighbourhood(const std::array<const Signs*, 3>& layers, std::size_t leaf)
      : mLayers(layers), mOrigin(layers[1]->layer.leaves[leaf]->origin()) {
    mFound[kOwn] = &layers[1]->bits[leaf];
    mKnown[kOwn] = true;
  }

  const Coord& origin() const { return mOrigin; }
  const InsideBits& own() const { return *mFound[kOwn]; }

  /// @param number  as returned by numberOf()
  const InsideBits* block(std::size_t number) const {
    if (!mKnown[number]) {
      const int k = static_cast<int>(number);
      const Signs* const layer = mLayers[number / 9];
      mFound[number] =
          layer ? layer->find(mOrigin[1] + (k / 3 % 3 - 1) * kBlock, mOrigin[2] + (k % 3 - 1) * kBlock) : nullptr;
      mKnown[number] = true;
    }
    return mFound[number];
  }
  const InsideBits* next(int axis, bool far) const {
    constexpr std::array<std::size_t, 3> kStep = {9, 3, 1};
    const std::size_t step = kStep[static_cast<std::size_t>(axis)];
    return block(far ? kOwn + step : kOwn - step);
  }

  /// The number of the block that holds a node, from 0 to 26.
  std::size_t numberOf(const Coord& node) const {
    const auto along = [&](int axis) { return ((node[axis] - mOrigin[axis]) >> kBlockLog2) + 1; };
    return static_cast<std::size_t>((along(0) * 3 + along(1)) * 3 + along(2));
  }

  static constexpr std::size_t kBlocks = 27;

 private:
  static constexpr std::size_t kOwn = 13;

  std::array<const Signs*, 3> mLayers;
  Coord mOrigin;
  mutable std::array<const InsideBits*, kBlocks> mFound{};
  mutable std::array<bool, kBlocks> mKnown{};
};

/// The island of a part, explored only as long as it may be a crumb.
class CrumbFilter::Flood {
 public:
  Flood(const CrumbFilter& filter, const Neighbourhood& around)
      : mPlan(filter.mPlan), mSource(filter.mSource), mAround(around) {}

  /// @param box  bounding box of the part
  /// @return whether the island is as small as a crumb, and ends there as far as is known
  bool fill(const InsideBits& part, const CoordBBox& box) {
    mBox = box;
    forEachNode(part, [&](openvdb::Index offset) {
      mark(nodeAt(mAround.origin(), offset));
      mNodes.push_back(nodeAt(mAround.origin(), offset));
    });
    // The neighbours of a part within its block are outside.
    const std::size_t count = mNodes.size();
    for (std::size_t i = 0; i < count && !mEndless; ++i) visitNeighbours(mNodes[i]);
    while (!mEndless) {
      if (!mWaiting.empty()) {
        const Coord node = mWaiting.back();
        mWaiting.pop_back();
        visitNeighbours(node);
      } else if (!mUnknown.empty()) {
        evaluateUnknown();
      } else {
        return true;
      }
    }
    return false;
  }

  /// The nodes of the island, if it is as small as a crumb.
  std::vector<Coord> takeNodes() { return std::move(mNodes); }

 private:
  static std::uint64_t bitOf(const Coord& node) {
    return std::uint64_t{1} << ((node[1] & (kBlock - 1)) * kBlock + (node[2] & (kBlock - 1)));
  }
  std::uint64_t& wordOf(const Coord& node) {
    return mSeen[mAround.numberOf(node)][static_cast<std::size_t>(node[0] & (kBlock - 1))];
  }
  void mark(const Coord& node) { wordOf(node) |= bitOf(node); }

  /// @param node  by value, because the vector of nodes grows meanwhile
  void visitNeighbours(Coord node) {
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        Coord next = node;
        next[axis] += step;
        visit(next);
      }
  }

  void visit(const Coord& node) {
    std::uint64_t& seen = wordOf(node);
    if (seen & bitOf(node)) return;
    seen |= bitOf(node);
    if (!mPlan.window.isInside(node)) {
      // Outside the known domain the island may continue.
      if (mPlan.whole.isInside(node))
        mUnknown.push_back(node);
      else
        mEndless = true;
      return;
    }
    const InsideBits* const block = mAround.block(mAround.numberOf(node));
    // If there is no leaf, all nodes of the block have the sign of the adjacent ones.
    if (!block)
      mEndless = true;
    else if ((*block)[static_cast<std::size_t>(node[0] & (kBlock - 1))] & bitOf(node))
      add(node);
  }

  void add(const Coord& node) {
    mBox.expand(node);
    if (longestSide(mBox) > mPlan.crumbs->longest) mEndless = true;
    mNodes.push_back(node);
    mWaiting.push_back(node);
  }

  void evaluateUnknown() {
    std::vector<julia::Point> points;
    for (const Coord& node : mUnknown) points.push_back(mSource.space.toFractal(node.asVec3d() * mPlan.voxelSize));
    std::vector<double> values(points.size());
    mSource.evaluator.evaluate(points, values, {});
    const std::vector<Coord> nodes = std::exchange(mUnknown, {});
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (isInside(julia::storedField(values[i]))) add(nodes[i]);
  }

  const FieldPlan& mPlan;
  const FieldSource& mSource;
  const Neighbourhood& mAround;
  CoordBBox mBox;
  bool mEndless = false;
  std::array<InsideBits, Neighbourhood::kBlocks> mSeen{};
  std::vector<Coord> mNodes, mWaiting;
  std::vector<Coord> mUnknown;  ///< nodes that no block contains
};

CrumbFilter::CrumbFilter(const FieldPlan& plan, const FieldSource& source, const Monitor& monitor)
    : mPlan(plan), mSource(source), mMonitor(monitor), mCounted(plan.crumbs.value().counted.value_or(plan.domain)) {}

CrumbFilter::~CrumbFilter() = default;

std::optional<CrumbFilter::Layer> CrumbFilter::add(Layer layer) {
  if (layer.leaves.empty()) return std::nullopt;
  auto signs = std::make_unique<Signs>();
  signs->x = layer.leaves.front()->origin()[0];
  signs->bits.resize(layer.leaves.size());
  for (const Leaf* leaf : layer.leaves) signs->places.emplace_back(leaf->origin()[1], leaf->origin()[2]);
  inParallel(layer.leaves.size(), 64, mMonitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) signs->bits[i] = insideBits(*layer.leaves[i]);
  });
  signs->layer = std::move(layer);
  mLayers.push_back(std::move(signs));
  if (mLayers.size() == 1) return std::nullopt;
  std::optional<Layer> done = clean(mLayers.size() - 2);
  while (mLayers.size() > 2) mLayers.pop_front();
  return done;
}

std::optional<CrumbFilter::Layer> CrumbFilter::finish() {
  if (mLayers.empty()) return std::nullopt;
  return clean(mLayers.size() - 1);
}

std::optional<CrumbFilter::Layer> CrumbFilter::clean(std::size_t which) {
  std::array<const Signs*, 3> layers = {nullptr, mLayers[which].get(), nullptr};
  const int x = layers[1]->x;
  if (which > 0 && mLayers[which - 1]->x == x - kBlock) layers[0] = mLayers[which - 1].get();
  if (which + 1 < mLayers.size() && mLayers[which + 1]->x == x + kBlock) layers[2] = mLayers[which + 1].get();
  Layer& layer = mLayers[which]->layer;
  inParallel(layer.leaves.size(), 16, mMonitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) clean(Neighbourhood(layers, i), *layer.leaves[i]);
  });
  return std::move(layer);
}

/// Drops the parts of crumbs that lie in a leaf.
void CrumbFilter::clean(const Neighbourhood& around, Leaf& leaf) {
  InsideBits rest = around.own();
  const auto isNone = [](const InsideBits& bits) {
    return std::all_of(bits.begin(), bits.end(), [](std::uint64_t word) { return word == 0; });
  };
  while (!isNone(rest)) {
    const InsideBits part = firstPart(rest);
    for (std::size_t x = 0; x < kBlock; ++x) rest[x] &= ~part[x];
    const CoordBBox box = boxOf(part, around.origin());
    // Most parts already exceed the length of a crumb within this block and the adjacent nodes.
    bool isLong = false, isWhole = true;
    for (int axis = 0; axis < 3; ++axis) {
      int length = box.dim()[axis];
      for (const bool far : {false, true}) {
        const int end = far ? box.max()[axis] : box.min()[axis];
        if (end == (far ? mPlan.window.max() : mPlan.window.min())[axis]) {
          isWhole = false;
          continue;
        }
        if (end != around.origin()[axis] + (far ? kBlock - 1 : 0)) continue;
        const InsideBits* const next = around.next(axis, far);
        const bool goesOn = !next || (far ? touch(part, *next, axis) : touch(*next, part, axis));
        length += goesOn ? 1 : 0;
        isWhole = isWhole && !goesOn;
      }
      isLong = isLong || length > mPlan.crumbs->longest;
    }
    if (isLong) continue;
    std::vector<Coord> nodes;  // of the whole crumb
    if (isWhole) {
      forEachNode(part, [&](openvdb::Index offset) { nodes.push_back(nodeAt(around.origin(), offset)); });
    } else {
      Flood flood(*this, around);
      if (!flood.fill(part, box)) continue;
      nodes = flood.takeNodes();
    }
    if (holdsDecided(nodes)) continue;
    std::optional<Coord> first;
    for (const Coord& node : nodes)
      if (mPlan.domain.isInside(node) && (!first || node < *first)) first = node;
    std::uint64_t dropped = 0, begun = 0;
    float* const values = leaf.buffer().data();
    forEachNode(part, [&](openvdb::Index offset) {
      values[offset] = -values[offset];
      const Coord node = nodeAt(around.origin(), offset);
      if (!mCounted.isInside(node)) return;
      ++dropped;
      if (node == first) ++begun;
    });
    mCrumbs += begun;
    mNodes += dropped;
  }
}

/// Whether the target alone decides that some of these inside nodes is inside.
bool CrumbFilter::holdsDecided(const std::vector<Coord>& nodes) const {
  const CrumbRule& rule = *mPlan.crumbs;
  if (!rule.exponent || !std::isfinite(rule.decided)) return false;
  return std::any_of(nodes.begin(), nodes.end(), [&](const Coord& node) {
    const openvdb::Vec3d at = rule.exponent->worldToIndex(node.asVec3d() * mPlan.voxelSize + mPlan.origin);
    return openvdb::tools::BoxSampler::sample(rule.exponent->tree(), at) <= rule.decided;
  });
}

void dropCrumbs(FractalField& field, const FieldPlan& plan, const FieldSource& source, const Monitor& monitor) {
  if (!plan.crumbs) return;
  std::vector<CrumbFilter::Leaf*> leaves;
  leaves.reserve(field.field->tree().leafCount());
  field.field->tree().getNodes(leaves);
  std::sort(leaves.begin(), leaves.end(), [](const auto* a, const auto* b) { return a->origin() < b->origin(); });
  CrumbFilter filter(plan, source, monitor);
  for (auto first = leaves.begin(); first != leaves.end();) {
    const auto last =
        std::find_if(first, leaves.end(), [&](const auto* leaf) { return leaf->origin()[0] != (*first)->origin()[0]; });
    filter.add({{first, last}, nullptr});
    first = last;
  }
  filter.finish();
  field.crumbs = filter.report();
}

}  // namespace vdbtools
