// SPDX-License-Identifier: Apache-2.0
/// @file block_evaluator.h
/// F at the nodes of whole blocks.
#pragma once

#include "vdbtools/fractal_field.h"

#include <openvdb/openvdb.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace vdbtools {

/// What a node outside of the domain holds, and one that is known to be outside of the set.
inline constexpr float kFieldOutside = 1;

struct EvaluatedBlock {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  std::unique_ptr<Leaf> field;       ///< active: evaluated, or left to an active-state pass of the caller
  std::unique_ptr<Leaf> iterations;  ///< if asked for
};

class BlockEvaluator {
 public:
  struct Options {
    double voxelSize = 0;       ///< world units
    openvdb::CoordBBox domain;  ///< nodes beyond hold kFieldOutside
    bool keepIterations = false;
  };

  BlockEvaluator(const FieldSource& source, const Options& options) : mSource(source), mOptions(options) {}

  /// Evaluates blocks in threads. Ends early, with blocks left empty, when the monitor is cancelled.
  /// @param origins  first nodes of the blocks
  std::vector<EvaluatedBlock> evaluate(std::span<const openvdb::Coord> origins, Monitor& monitor);

  std::uint64_t evaluatedNodes() const { return mEvaluated; }

 private:
  struct Scratch;
  EvaluatedBlock evaluateOne(const openvdb::Coord& origin, Scratch& scratch);

  FieldSource mSource;
  Options mOptions;
  std::atomic<std::uint64_t> mEvaluated{0};
};

}  // namespace vdbtools
