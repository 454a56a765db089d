// SPDX-License-Identifier: Apache-2.0
#include "block_evaluator.h"

#include "block_layers.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

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
};

std::vector<EvaluatedBlock> BlockEvaluator::evaluate(std::span<const Coord> origins, Monitor& monitor) {
  std::vector<EvaluatedBlock> blocks(origins.size());
  tbb::enumerable_thread_specific<Scratch> scratch;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size(), 4), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      if (monitor.cancelled()) return;
      blocks[i] = evaluateOne(origins[i], scratch.local());
    }
    monitor.advance(range.size());
  });
  return blocks;
}

EvaluatedBlock BlockEvaluator::evaluateOne(const Coord& origin, Scratch& scratch) {
  EvaluatedBlock block;
  block.field = std::make_unique<Leaf>(origin, kFieldOutside, true);
  if (mOptions.keepIterations) block.iterations = std::make_unique<Leaf>(origin, 0.0f, false);
  scratch.points.clear();
  scratch.offsets.clear();
  // Each coordinate is that of its index alone, whichever block asks.
  std::array<julia::Point, kBlock> at;
  for (int k = 0; k < kBlock; ++k)
    at[static_cast<std::size_t>(k)] = mSource.space.toFractal(origin.offsetBy(k).asVec3d() * mOptions.voxelSize);
  const bool within = mOptions.domain.isInside(block.field->getNodeBoundingBox());
  for (Index offset = 0; offset < Leaf::SIZE; ++offset) {
    if (!within && !mOptions.domain.isInside(block.field->offsetToGlobalCoord(offset))) continue;
    scratch.offsets.push_back(offset);
    scratch.points.push_back({at[offset >> 6][0], at[offset >> 3 & 7][1], at[offset & 7][2]});
  }
  scratch.values.resize(scratch.points.size());
  scratch.steps.resize(mOptions.keepIterations ? scratch.points.size() : 0);
  mSource.evaluator.evaluate(scratch.points, scratch.values, scratch.steps);
  for (std::size_t k = 0; k < scratch.offsets.size(); ++k) {
    block.field->setValueOnly(scratch.offsets[k], stored(scratch.values[k]));
    if (mOptions.keepIterations) block.iterations->setValueOn(scratch.offsets[k], static_cast<float>(scratch.steps[k]));
  }
  mEvaluated += scratch.points.size();
  return block;
}

}  // namespace vdbtools
