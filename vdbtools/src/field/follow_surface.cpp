// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/field/lattice_options.h"

#include "base/in_parallel.h"
#include "distance/leaves.h"
#include "field/block_evaluator.h"
#include "field/block_layers.h"
#include "field/crumb_filter.h"
#include "field/leaf_signs.h"
#include "field/undecided_blocks.h"

#include <openvdb/tools/Morphology.h>
#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::Index;
using Leaf = EvaluatedBlock::Leaf;

/// The 26 blocks around a block: cells that begin in one reach into the next ones across faces, edges and corners.
constexpr int kAround = 27;
Coord towards(int direction) { return {direction / 9 - 1, direction / 3 % 3 - 1, direction % 3 - 1}; }

/// The signs of the nodes that touch the neighbour in a direction.
struct TouchingSigns {
  bool inside = false, outside = false;
};
TouchingSigns signsTowards(const Leaf& leaf, const Coord& direction) {
  TouchingSigns signs;
  const float* values = leaf.buffer().data();
  const auto first = [&](int axis) { return direction[axis] > 0 ? kBlock - 1 : 0; };
  const auto last = [&](int axis) { return direction[axis] < 0 ? 0 : kBlock - 1; };
  for (int x = first(0); x <= last(0); ++x)
    for (int y = first(1); y <= last(1); ++y)
      for (int z = first(2); z <= last(2); ++z)
        (isInside(values[(x * kBlock + y) * kBlock + z]) ? signs.inside : signs.outside) = true;
  return signs;
}

/// Counts the crossing edges that begin at a leaf's nodes.
/// @param around  see LeafSigns; only neighbours across a face matter
std::uint64_t crossingsFrom(const LeafSigns::Neighbours& around) {
  const LeafSigns signs(around);
  std::uint64_t count = 0;
  for (unsigned x = 0; x < LeafSigns::kSide; ++x)
    for (unsigned y = 0; y < LeafSigns::kSide; ++y)
      for (int axis = 0; axis < 3; ++axis) count += static_cast<unsigned>(std::popcount(signs.crossings(x, y, axis)));
  return count;
}

/// Counts the crossing edges of a field, which are those that begin in its leaves.
std::uint64_t crossingsOf(const openvdb::FloatTree& tree, const Monitor& monitor) {
  const std::vector<const Leaf*> leaves = leavesOf(tree);
  std::atomic<std::uint64_t> count{0};
  inParallel(leaves.size(), 256, monitor, [&](std::size_t begin, std::size_t end) {
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(tree);
    std::uint64_t part = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const InsideBits own = insideBits(*leaves[i]);
      std::array<InsideBits, 3> behind;
      LeafSigns::Neighbours around{&own};
      for (int axis = 0; axis < 3; ++axis) {
        Coord next = leaves[i]->origin();
        next[axis] += kBlock;
        const Leaf* const leaf = accessor.probeConstLeaf(next);
        if (!leaf) continue;
        InsideBits& bits = behind[static_cast<std::size_t>(axis)];
        bits = insideBits(*leaf);
        around[std::size_t{1} << axis] = &bits;
      }
      part += crossingsFrom(around);
    }
    count += part;
  });
  return count;
}

class Follower {
 public:
  Follower(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& field, int stride,
           Monitor& monitor)
      : mPlan(plan),
        mSource(source),
        mStride(stride),
        mMonitor(monitor),
        mBlocks(field.everyNode ? *plan.blocks : undecidedBlocks(plan, source, monitor)),
        mKnown(mBlocks),
        mEvaluator(source, {.voxelSize = plan.voxelSize,
                            .domain = plan.domain,
                            .window = plan.window,
                            .keepIterations = field.keepIterations,
                            .everyValue = field.everyNode,
                            .proofs = field.everyNode ? Proofs::None : Proofs::Eighths}) {
    // Each adjacent block has one sign, the sign of its own seed.
    openvdb::tools::dilateActiveValues(mKnown, 1, openvdb::tools::NN_FACE_EDGE_VERTEX, openvdb::tools::EXPAND_TILES);
    mKnown.voxelizeActiveTiles();
  }

  void follow(FractalField& result, FollowReport& report) {
    std::vector<Coord> wave = start();
    mMonitor.begin(PhaseKind::FollowingTheSurface, 0);
    while (!wave.empty()) {
      std::vector<Coord> origins;
      for (const Coord& block : wave) origins.push_back(block << kBlockLog2);
      std::vector<EvaluatedBlock> blocks = mEvaluator.evaluate(origins, mMonitor);
      mMonitor.throwIfCancelled();
      for (std::size_t i = 0; i < wave.size(); ++i) spread(wave[i], blocks[i]);
      for (EvaluatedBlock& block : blocks) {
        if (block.field) result.field->tree().addLeaf(block.field.release());
        if (block.iterations) result.iterations->tree().addLeaf(block.iterations.release());
      }
      wave = std::exchange(mNext, {});
      std::sort(wave.begin(), wave.end());
    }
    report.foundVertices = crossingsOf(result.field->tree(), mMonitor);
    report.visitedBlocks = mVisited.activeVoxelCount();
    result.evaluatedNodes = mEvaluator.evaluatedNodes();
  }

  /// Evaluates a sample of the blocks that were left out.
  void probe(std::uint64_t probes, FollowReport& report) {
    std::vector<Coord> leftOut;
    report.shellBlocks = mBlocks.activeVoxelCount();
    const std::uint64_t count = report.shellBlocks - report.visitedBlocks;
    // Always the same ones: numbers of blocks in the order of the tree.
    std::mt19937_64 random(1);
    std::vector<std::uint64_t> chosen;
    for (std::uint64_t i = 0; i < probes && count > 0; ++i) chosen.push_back(random() % count);
    std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    std::uint64_t at = 0;
    auto next = chosen.begin();
    openvdb::tree::ValueAccessor<const BlockSet> visited(mVisited);
    for (auto block = mBlocks.cbeginValueOn(); block && next != chosen.end(); ++block) {
      if (visited.isValueOn(block.getCoord())) continue;
      if (at++ != *next) continue;
      leftOut.push_back(block.getCoord() << kBlockLog2);
      ++next;
    }
    const std::vector<EvaluatedBlock> blocks = mEvaluator.evaluate(leftOut, mMonitor);
    mMonitor.throwIfCancelled();
    std::atomic<std::uint64_t> crossings{0};
    inParallel(blocks.size(), 16, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        if (blocks[i].field) crossings += crossingsFromAlone(*blocks[i].field);
    });
    report.probedBlocks = leftOut.size();
    if (!leftOut.empty())
      report.missedVertices =
          static_cast<double>(crossings.load()) * static_cast<double>(count) / static_cast<double>(leftOut.size());
  }

 private:
  /// Finds the signs at the seeds. @return the blocks where they differ, within the block or from the next block's
  std::vector<Coord> start() {
    std::vector<Coord> blocks;
    for (auto block = mKnown.cbeginValueOn(); block; ++block) blocks.push_back(block.getCoord());
    std::vector<std::uint8_t> inside(blocks.size()), mixed(blocks.size());
    mMonitor.begin(PhaseKind::Seeds, blocks.size());
    inParallel(blocks.size(), 256, mMonitor, [&](std::size_t begin, std::size_t end) {
      seed(std::span(blocks).subspan(begin, end - begin), inside.data() + begin, mixed.data() + begin);
      mMonitor.advance(end - begin);
    });
    openvdb::tree::ValueAccessor<BlockSet> insideAt(mInside);
    for (std::size_t i = 0; i < blocks.size(); ++i)
      if (inside[i]) insideAt.setValueOn(blocks[i]);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (mixed[i]) visit(blocks[i]);
      for (int axis = 0; axis < 3; ++axis) {
        Coord next = blocks[i];
        ++next[axis];
        if (!mKnown.isValueOn(next) || insideAt.isValueOn(next) == bool(inside[i])) continue;
        visit(blocks[i]);
        visit(next);
      }
    }
    std::sort(mNext.begin(), mNext.end());
    return std::exchange(mNext, {});
  }

  void seed(std::span<const Coord> blocks, std::uint8_t* inside, std::uint8_t* mixed) const {
    // If the stride exceeds a block, blocks share the seed at the corner of their cube.
    const int step = std::min(mStride, kBlock), perSide = kBlock / step, together = std::max(mStride / kBlock, 1);
    std::vector<julia::Point> points;
    std::vector<bool> within;
    for (const Coord& block : blocks)
      for (int k = 0; k < perSide * perSide * perSide; ++k) {
        const Coord node =
            ((block & ~(together - 1)) << kBlockLog2)
                .offsetBy(k / perSide / perSide * step, k / perSide % perSide * step, k % perSide * step);
        within.push_back(mPlan.domain.isInside(node));
        points.push_back(mSource.space.toFractal(node.asVec3d() * mPlan.voxelSize));
      }
    std::vector<double> values(points.size());
    mSource.evaluator.evaluate(points, values, {});
    const std::size_t each = points.size() / std::max<std::size_t>(blocks.size(), 1);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      std::size_t count = 0;
      for (std::size_t k = i * each; k < (i + 1) * each; ++k) count += within[k] && values[k] < 0 ? 1 : 0;
      inside[i] = within[i * each] && values[i * each] < 0;
      mixed[i] = count > 0 && count < each;
    }
  }

  /// Counts the crossing edges that begin in a leaf whose neighbours were not evaluated.
  std::uint64_t crossingsFromAlone(const Leaf& leaf) const {
    // The end nodes of the edges that leave it, one face after the other.
    constexpr std::size_t kFace = kBlock * kBlock;
    std::vector<Coord> nodes;
    for (int axis = 0; axis < 3; ++axis)
      for (int u = 0; u < kBlock; ++u)
        for (int v = 0; v < kBlock; ++v) {
          Coord node = leaf.origin();
          node[axis] += kBlock;
          node[(axis + 1) % 3] += u;
          node[(axis + 2) % 3] += v;
          nodes.push_back(node);
        }
    std::vector<julia::Point> points;
    for (const Coord& node : nodes) points.push_back(mSource.space.toFractal(node.asVec3d() * mPlan.voxelSize));
    std::vector<double> values(points.size());
    mSource.evaluator.evaluate(points, values, {});
    const InsideBits own = insideBits(leaf);
    std::array<InsideBits, 3> behind{};
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Coord at = nodes[i] & (kBlock - 1);
      if (values[i] < 0 && mPlan.domain.isInside(nodes[i]))
        behind[i / kFace][static_cast<std::size_t>(at[0])] |= std::uint64_t{1} << (at[1] * kBlock + at[2]);
    }
    LeafSigns::Neighbours around{&own};
    for (std::size_t axis = 0; axis < 3; ++axis) around[std::size_t{1} << axis] = &behind[axis];
    return crossingsFrom(around);
  }

  /// Visits the neighbours whose assumed sign differs from that of an adjacent node.
  void spread(const Coord& block, const EvaluatedBlock& evaluated) {
    for (int i = 0; i < kAround; ++i) {
      const Coord direction = towards(i), next = block + direction;
      if (direction == Coord(0) || mVisited.isValueOn(next)) continue;
      TouchingSigns signs;
      if (evaluated.field)
        signs = signsTowards(*evaluated.field, direction);
      else
        (evaluated.decision == julia::Decision::Inside ? signs.inside : signs.outside) = true;
      if (mInside.isValueOn(next) ? signs.outside : signs.inside) visit(next);
    }
  }

  void visit(const Coord& block) {
    if (!mBlocks.isValueOn(block) || mVisited.isValueOn(block)) return;
    mVisited.setValueOn(block);
    mNext.push_back(block);
  }

  const FieldPlan& mPlan;
  FieldSource mSource;
  int mStride;
  Monitor& mMonitor;
  BlockSet mBlocks;            // the plan's blocks without the proved ones
  BlockSet mKnown;             // mBlocks and the adjacent blocks
  BlockSet mInside, mVisited;  // subsets of mKnown
  std::vector<Coord> mNext;
  BlockEvaluator mEvaluator;
};

}  // namespace

bool isSeedStride(int stride) {
  return stride >= 1 && stride <= 64 && std::has_single_bit(static_cast<unsigned>(stride));
}

FractalField followSurface(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& field,
                           const FollowOptions& options, FollowReport& report, Monitor& monitor) {
  if (!isSeedStride(options.seedStride))
    throw std::invalid_argument("the stride of seeds is " + std::to_string(options.seedStride) +
                                " voxels; it must be a power of 2, at most 64");
  report = {};
  FractalField result = emptyField(plan, field.keepIterations);
  Follower follower(plan, source, field, options.seedStride, monitor);
  follower.follow(result, report);
  follower.probe(options.probes, report);
  fillTiles(result);
  dropCrumbs(result, plan, source, monitor);
  return result;
}

}  // namespace vdbtools
