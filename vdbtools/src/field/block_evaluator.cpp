// SPDX-License-Identifier: Apache-2.0
#include "field/block_evaluator.h"

#include "field/block_layers.h"
#include "field/undecided_blocks.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>

namespace vdbtools {
namespace {

using julia::NodeBlock;
using openvdb::Coord;
using openvdb::Index;
using Leaf = EvaluatedBlock::Leaf;

}  // namespace

struct BlockEvaluator::Scratch {
  /// @param nodes  number of nodes evaluated together, at least the nodes of a block
  explicit Scratch(std::size_t nodes) : points(nodes), offsets(nodes), values(nodes), steps(nodes) {}

  std::vector<julia::Point> points;
  std::vector<Index> offsets;
  std::vector<double> values;
  std::vector<int> steps;
  std::size_t count = 0;  ///< number of waiting nodes
  struct Waiting {
    EvaluatedBlock* block;
    std::size_t end;  ///< end of its nodes among the waiting ones
  };
  std::vector<Waiting> waiting;
  std::vector<NodeBlock> blocks;  ///< waiting blocks, other than those of these nodes

  std::vector<julia::Decision> decisions;
  std::vector<Coord> undecided, corners;
  std::vector<std::size_t> which;
};

/// Whether the evaluator of F makes signs of many blocks at once, and signs are all that is needed.
bool BlockEvaluator::signsAreEnough() const {
  return !mOptions.keepIterations && !mOptions.everyValue && mSource.evaluator.preferredNodes() > 0;
}

std::size_t BlockEvaluator::preferredBlocks() const {
  return signsAreEnough() ? mSource.evaluator.preferredNodes() / Leaf::SIZE : 0;
}

std::vector<EvaluatedBlock> BlockEvaluator::evaluate(std::span<const Coord> origins, Monitor& monitor) {
  if (signsAreEnough()) return evaluateSigns(origins, monitor);
  std::vector<EvaluatedBlock> blocks(origins.size());
  const std::size_t batch = std::max<std::size_t>(mSource.evaluator.preferredBatch(), Leaf::SIZE);
  tbb::enumerable_thread_specific<Scratch> scratch(batch);
  constexpr std::size_t kFewest = 32;
  const std::size_t together = std::max(kFewest, batch / Leaf::SIZE);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size(), together), [&](const auto& range) {
    for (std::size_t first = range.begin(); first < range.end(); first += together) {
      if (monitor.cancelled()) return;
      const std::size_t count = std::min(together, range.end() - first);
      evaluatePart(origins.subspan(first, count), std::span(blocks).subspan(first, count), scratch.local());
      monitor.advance(count);
    }
  });
  return blocks;
}

/// Evaluates all blocks in one call of the evaluator; the proofs before it, and the leaves, are made in threads.
std::vector<EvaluatedBlock> BlockEvaluator::evaluateSigns(std::span<const Coord> origins, Monitor& monitor) {
  constexpr std::size_t kTogether = 32;
  const auto inParts = [&](std::size_t size, const auto& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, size, kTogether), [&](const auto& range) {
      for (std::size_t first = range.begin(); first < range.end(); first += kTogether)
        if (!monitor.cancelled()) body(first, std::min(kTogether, range.end() - first));
    });
  };
  std::vector<EvaluatedBlock> blocks(origins.size());
  std::vector<julia::SignBlock> all(origins.size());
  tbb::enumerable_thread_specific<Scratch> scratch(std::size_t{0});
  inParts(origins.size(), [&](std::size_t first, std::size_t count) {
    Scratch& own = scratch.local();
    const auto some = std::span(blocks).subspan(first, count);
    decide(origins.subspan(first, count), some, own);
    for (std::size_t i = 0; i < own.undecided.size(); ++i)
      beginSigns(own.undecided[i], std::span<const julia::Decision>(own.decisions).subspan(8 * i, 8),
                 some[own.which[i]], all[first + own.which[i]]);
  });
  if (monitor.cancelled()) return std::vector<EvaluatedBlock>(origins.size());
  std::vector<std::size_t> which;
  std::vector<julia::SignBlock> signs;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (blocks[i].field) {
      which.push_back(i);
      signs.push_back(all[i]);
    }
  mSource.evaluator.evaluateSigns(mSource.lattice(mOptions.voxelSize), signs);
  inParts(signs.size(), [&](std::size_t first, std::size_t count) {
    std::uint64_t evaluated = 0;
    for (std::size_t i = first; i < first + count; ++i) {
      Leaf& leaf = *blocks[which[i]].field;
      float* const values = leaf.buffer().data();
      constexpr auto kSign = static_cast<float>(julia::kFieldLimit);
      for (auto node = leaf.cbeginValueOn(); node; ++node) {
        const Index at = node.pos();
        values[at] = signs[i].inside[at / 64] >> at % 64 & 1 ? -kSign : kSign;
        ++evaluated;
      }
    }
    mEvaluated += evaluated;
  });
  monitor.advance(origins.size());
  return blocks;
}

/// Creates the block's leaf, whose active nodes are those to evaluate.
void BlockEvaluator::beginSigns(const Coord& origin, std::span<const julia::Decision> parts, EvaluatedBlock& block,
                                julia::SignBlock& signs) const {
  block.field = std::make_unique<Leaf>(origin, kFieldOutside, false);
  signs.origin = {origin[0], origin[1], origin[2]};
  signs.wanted = 0;
  const bool within = mOptions.window.isInside(block.field->getNodeBoundingBox());
  constexpr Index kHalf = kBlock / 2;
  float* const values = block.field->buffer().data();
  Leaf::NodeMaskType active;
  for (Index first = 0; first < Leaf::SIZE; first += kHalf) {
    const Index x = first >> 2 * kBlockLog2, y = first >> kBlockLog2 & (kBlock - 1), z = first & (kBlock - 1);
    const Index part = x / kHalf * 4 + y / kHalf * 2 + z / kHalf;
    if (parts[part] == julia::Decision::Inside) std::fill_n(values + first, kHalf, -kFieldOutside);
    if (parts[part] != julia::Decision::Undecided) continue;
    for (Index k = 0; k < kHalf; ++k) {
      if (!within && !mOptions.window.isInside(block.field->offsetToGlobalCoord(first + k))) continue;
      active.setOn(first + k);
      signs.wanted |= static_cast<std::uint8_t>(1u << part);
    }
  }
  block.field->setValueMask(active);
}

/// Sets the decisions about blocks, and finds those that stay undecided, with the decisions about their eighths.
void BlockEvaluator::decide(std::span<const Coord> origins, std::span<EvaluatedBlock> blocks, Scratch& scratch) const {
  constexpr std::size_t kParts = 8;
  scratch.undecided.clear();
  scratch.which.clear();
  if (mOptions.proofs != Proofs::None) {
    decideCubes(origins, kBlock, mOptions.voxelSize, mOptions.domain, mSource, scratch.decisions);
    for (std::size_t i = 0; i < origins.size(); ++i) {
      blocks[i].decision = scratch.decisions[i];
      if (scratch.decisions[i] != julia::Decision::Undecided) continue;
      scratch.undecided.push_back(origins[i]);
      scratch.which.push_back(i);
    }
  } else {
    for (std::size_t i = 0; i < origins.size(); ++i) scratch.which.push_back(i);
    scratch.undecided.assign(origins.begin(), origins.end());
  }
  if (mOptions.proofs == Proofs::Eighths) {
    scratch.corners.clear();
    for (const Coord& origin : scratch.undecided) addEighths(origin, scratch.corners);
    decideCubes(scratch.corners, kBlock / 2, mOptions.voxelSize, mOptions.domain, mSource, scratch.decisions);
  } else {
    scratch.decisions.assign(kParts * scratch.undecided.size(), julia::Decision::Undecided);
  }
}

void BlockEvaluator::evaluatePart(std::span<const Coord> origins, std::span<EvaluatedBlock> blocks, Scratch& scratch) {
  constexpr std::size_t kParts = 8;
  decide(origins, blocks, scratch);
  for (std::size_t i = 0; i < scratch.undecided.size(); ++i) {
    begin(scratch.undecided[i], std::span<const julia::Decision>(scratch.decisions).subspan(kParts * i, kParts),
          blocks[scratch.which[i]], scratch);
    if (scratch.count + (scratch.blocks.size() + 1) * Leaf::SIZE > scratch.points.size()) evaluateWaiting(scratch);
  }
  evaluateWaiting(scratch);
}

/// Creates the block's leaves and queues its nodes for evaluation.
void BlockEvaluator::begin(const Coord& origin, std::span<const julia::Decision> parts, EvaluatedBlock& block,
                           Scratch& scratch) const {
  block.field = std::make_unique<Leaf>(origin, kFieldOutside, false);
  // Each coordinate depends on its index alone, whatever the block.
  std::array<julia::Point, kBlock> at;
  for (int k = 0; k < kBlock; ++k)
    at[static_cast<std::size_t>(k)] = mSource.space.toFractal(origin.offsetBy(k).asVec3d() * mOptions.voxelSize);
  if (mOptions.keepIterations || mOptions.everyValue || !mOptions.window.isInside(block.field->getNodeBoundingBox()))
    return queueNodes(parts, at, block, scratch);
  float* const values = block.field->buffer().data();
  NodeBlock nodes{.field = std::span<float, NodeBlock::kSize>(values, NodeBlock::kSize)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t k = 0; k < NodeBlock::kSide; ++k) nodes.at[axis][k] = at[k][axis];
  Leaf::NodeMaskType active(true);
  for (unsigned part = 0; part < 8; ++part) {
    if (parts[part] == julia::Decision::Undecided) continue;
    nodes.wanted &= static_cast<std::uint8_t>(~(1u << part));
    constexpr unsigned kHalf = kBlock / 2;
    for (unsigned row = 0; row < kHalf * kHalf; ++row) {
      const unsigned x = (part >> 2) * kHalf + row / kHalf, y = (part >> 1 & 1) * kHalf + row % kHalf;
      const Index first = (x * kBlock + y) * kBlock + (part & 1) * kHalf;
      if (parts[part] == julia::Decision::Inside) std::fill_n(values + first, kHalf, -kFieldOutside);
      for (unsigned k = 0; k < kHalf; ++k) active.setOff(first + k);
    }
  }
  block.field->setValueMask(active);
  scratch.blocks.push_back(nodes);
}

/// Queues the nodes of a block one by one.
void BlockEvaluator::queueNodes(std::span<const julia::Decision> parts, std::span<const julia::Point> at,
                                EvaluatedBlock& block, Scratch& scratch) const {
  const bool within = mOptions.window.isInside(block.field->getNodeBoundingBox());
  constexpr Index kHalf = kBlock / 2;
  float* const values = block.field->buffer().data();
  Leaf::NodeMaskType active;
  std::size_t count = scratch.count;
  for (Index first = 0; first < Leaf::SIZE; first += kHalf) {
    const Index x = first >> 2 * kBlockLog2, y = first >> kBlockLog2 & (kBlock - 1), z = first & (kBlock - 1);
    const julia::Decision decision = parts[x / kHalf * 4 + y / kHalf * 2 + z / kHalf];
    if (decision == julia::Decision::Inside) std::fill_n(values + first, kHalf, -kFieldOutside);
    if (decision != julia::Decision::Undecided) continue;
    for (Index k = 0; k < kHalf; ++k) {
      if (!within && !mOptions.window.isInside(block.field->offsetToGlobalCoord(first + k))) continue;
      active.setOn(first + k);
      scratch.offsets[count] = first + k;
      scratch.points[count++] = {at[x][0], at[y][1], at[z + k][2]};
    }
  }
  block.field->setValueMask(active);
  if (mOptions.keepIterations) {
    block.iterations = std::make_unique<Leaf>(block.field->origin(), 0.0f, false);
    block.iterations->setValueMask(active);
  }
  scratch.count = count;
  scratch.waiting.push_back({&block, count});
}

void BlockEvaluator::evaluateWaiting(Scratch& scratch) {
  const std::size_t count = scratch.count;
  std::uint64_t evaluated = count;
  const auto steps = std::span(scratch.steps).first(mOptions.keepIterations ? count : 0);
  if (count > 0)
    mSource.evaluator.evaluate(std::span(scratch.points).first(count), std::span(scratch.values).first(count), steps);
  std::size_t k = 0;
  for (const auto& [block, end] : scratch.waiting) {
    float* const values = block->field->buffer().data();
    float* const iterations = block->iterations ? block->iterations->buffer().data() : nullptr;
    for (; k < end; ++k) {
      values[scratch.offsets[k]] = julia::storedField(scratch.values[k]);
      if (iterations) iterations[scratch.offsets[k]] = static_cast<float>(steps[k]);
    }
  }
  if (!scratch.blocks.empty()) mSource.evaluator.evaluateBlocks(scratch.blocks);
  for (const NodeBlock& nodes : scratch.blocks)
    evaluated += static_cast<unsigned>(std::popcount(nodes.wanted)) * NodeBlock::kSize / 8;
  mEvaluated += evaluated;
  scratch.count = 0;
  scratch.waiting.clear();
  scratch.blocks.clear();
}

}  // namespace vdbtools
