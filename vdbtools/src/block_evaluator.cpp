// SPDX-License-Identifier: Apache-2.0
#include "block_evaluator.h"

#include "block_layers.h"
#include "undecided_blocks.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::Index;
using Leaf = EvaluatedBlock::Leaf;

/// Keeps the sign, whatever rounding to 32 bits does.
float stored(double field) {
  const float value = static_cast<float>(field);
  return value == 0 && field < 0 ? -std::numeric_limits<float>::min() : value;
}

}  // namespace

struct BlockEvaluator::Scratch {
  std::vector<julia::Point> points;
  std::vector<Index> offsets;
  std::vector<double> values;
  std::vector<int> steps;
  std::vector<julia::Decision> decisions;
  std::vector<Coord> undecided, corners;
  std::vector<std::size_t> which;
};

std::vector<EvaluatedBlock> BlockEvaluator::evaluate(std::span<const Coord> origins, Monitor& monitor) {
  std::vector<EvaluatedBlock> blocks(origins.size());
  tbb::enumerable_thread_specific<Scratch> scratch;
  constexpr std::size_t kTogether = 32;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size(), kTogether), [&](const auto& range) {
    for (std::size_t first = range.begin(); first < range.end(); first += kTogether) {
      if (monitor.cancelled()) return;
      const std::size_t count = std::min(kTogether, range.end() - first);
      evaluatePart(origins.subspan(first, count), std::span(blocks).subspan(first, count), scratch.local());
      monitor.advance(count);
    }
  });
  return blocks;
}

void BlockEvaluator::evaluatePart(std::span<const Coord> origins, std::span<EvaluatedBlock> blocks, Scratch& scratch) {
  constexpr std::size_t kParts = 8;
  scratch.undecided.clear();
  scratch.which.clear();
  if (mOptions.prove) {
    decideCubes(origins, kBlock, mOptions.voxelSize, mOptions.domain, mSource, scratch.decisions);
    for (std::size_t i = 0; i < origins.size(); ++i) {
      blocks[i].decision = scratch.decisions[i];
      if (scratch.decisions[i] != julia::Decision::Undecided) continue;
      scratch.undecided.push_back(origins[i]);
      scratch.which.push_back(i);
    }
    scratch.corners.clear();
    for (const Coord& origin : scratch.undecided)
      for (unsigned k = 0; k < kParts; ++k) {
        const auto at = [&](unsigned bit) { return k >> bit & 1 ? kBlock / 2 : 0; };
        scratch.corners.push_back(origin.offsetBy(at(2), at(1), at(0)));
      }
    decideCubes(scratch.corners, kBlock / 2, mOptions.voxelSize, mOptions.domain, mSource, scratch.decisions);
  } else {
    for (std::size_t i = 0; i < origins.size(); ++i) scratch.which.push_back(i);
    scratch.undecided.assign(origins.begin(), origins.end());
    scratch.decisions.assign(kParts * origins.size(), julia::Decision::Undecided);
  }
  for (std::size_t i = 0; i < scratch.undecided.size(); ++i)
    evaluateOne(scratch.undecided[i], std::span<const julia::Decision>(scratch.decisions).subspan(kParts * i, kParts),
                blocks[scratch.which[i]], scratch);
}

void BlockEvaluator::evaluateOne(const Coord& origin, std::span<const julia::Decision> parts, EvaluatedBlock& block,
                                 Scratch& scratch) {
  block.field = std::make_unique<Leaf>(origin, kFieldOutside, false);
  if (mOptions.keepIterations) block.iterations = std::make_unique<Leaf>(origin, 0.0f, false);
  scratch.points.clear();
  scratch.offsets.clear();
  // Each coordinate is that of its index alone, whichever block asks.
  std::array<julia::Point, kBlock> at;
  for (int k = 0; k < kBlock; ++k)
    at[static_cast<std::size_t>(k)] = mSource.space.toFractal(origin.offsetBy(k).asVec3d() * mOptions.voxelSize);
  const bool within = mOptions.domain.isInside(block.field->getNodeBoundingBox());
  constexpr Index kHalf = kBlock / 2;
  for (Index offset = 0; offset < Leaf::SIZE; ++offset) {
    const Index x = offset >> 2 * kBlockLog2, y = offset >> kBlockLog2 & (kBlock - 1), z = offset & (kBlock - 1);
    const julia::Decision decision = parts[x / kHalf * 4 + y / kHalf * 2 + z / kHalf];
    if (decision == julia::Decision::Inside) block.field->setValueOnly(offset, -kFieldOutside);
    if (decision != julia::Decision::Undecided) continue;
    if (!within && !mOptions.domain.isInside(block.field->offsetToGlobalCoord(offset))) continue;
    scratch.offsets.push_back(offset);
    scratch.points.push_back({at[x][0], at[y][1], at[z][2]});
  }
  scratch.values.resize(scratch.points.size());
  scratch.steps.resize(mOptions.keepIterations ? scratch.points.size() : 0);
  mSource.evaluator.evaluate(scratch.points, scratch.values, scratch.steps);
  for (std::size_t k = 0; k < scratch.offsets.size(); ++k) {
    block.field->setValueOn(scratch.offsets[k], stored(scratch.values[k]));
    if (mOptions.keepIterations) block.iterations->setValueOn(scratch.offsets[k], static_cast<float>(scratch.steps[k]));
  }
  mEvaluated += scratch.points.size();
}

}  // namespace vdbtools
