// SPDX-License-Identifier: Apache-2.0
/// @file evaluated_layers.h
/// The layers of a set of blocks, evaluated. If the evaluator wants many blocks at a time, as devices do, it gets
/// several layers at once, and evaluates the next ones while the last ones are used.
#pragma once

#include "field/block_evaluator.h"
#include "field/block_layers.h"

#include <cstddef>
#include <future>
#include <vector>

namespace vdbtools {

class EvaluatedLayers {
 public:
  using Layer = std::vector<EvaluatedBlock>;

  /// All must outlive this.
  EvaluatedLayers(BlockLayers& layers, BlockEvaluator& evaluator, Monitor& monitor)
      : mLayers(layers), mEvaluator(evaluator), mMonitor(monitor) {}

  /// The next layers in the order of x, one at least; none at the end. The blocks of a layer have one x, and are
  /// ordered by y, then z.
  /// @throw Interrupted
  std::vector<Layer> next();

 private:
  /// The blocks that are evaluated together, and where each of their layers ends.
  struct Batch {
    std::vector<openvdb::Coord> origins;
    std::vector<std::size_t> ends;
  };
  Batch nextBatch(std::size_t blocks);
  std::vector<Layer> evaluate(const Batch& batch);
  void beginNext(std::size_t blocks);

  BlockLayers& mLayers;
  BlockEvaluator& mEvaluator;
  Monitor& mMonitor;
  std::future<std::vector<Layer>> mNext;  ///< if it has been begun
};

}  // namespace vdbtools
