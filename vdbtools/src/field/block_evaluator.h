// SPDX-License-Identifier: Apache-2.0
/// @file block_evaluator.h
/// F at the nodes of whole blocks. Nodes are not evaluated in a block, or a part of one, whose sign is proved.
#pragma once

#include "field/undecided_blocks.h"

#include "vdbtools/base/grids.h"
#include "vdbtools/field/fractal_field.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace vdbtools {

/// The value of nodes outside the domain, and of those that are proved to be outside the set.
inline constexpr float kFieldOutside = 1;

struct EvaluatedBlock {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  /// Active nodes were evaluated; at some of them julia::kFieldLimit says no more than that F >= 0, unless
  /// Options::everyValue. Empty: F has one sign at all nodes of the block and at those next to it.
  std::unique_ptr<Leaf> field;
  std::unique_ptr<Leaf> iterations;  ///< if asked for
  /// That one sign, where the field is empty.
  julia::Decision decision = julia::Decision::Undecided;
};

/// A plan's field before anything is evaluated.
FractalField emptyField(const FieldPlan& plan, bool keepIterations);

/// Gives the tiles of a field the sign of the leaves next to them.
void fillTiles(FractalField& field);

class BlockEvaluator {
 public:
  struct Options {
    double voxelSize = 0;       ///< world units
    openvdb::CoordBBox domain;  ///< nodes beyond hold kFieldOutside
    openvdb::CoordBBox window;  ///< the nodes of the domain that are evaluated; others hold kFieldOutside, too
    bool keepIterations = false;
    bool everyValue = false;  ///< F itself is wanted at every node, and not its sign alone
    /// Nodes are skipped where the sign of F is proved, there and at the nodes next to them.
    Proofs proofs = Proofs::None;
  };

  BlockEvaluator(const FieldSource& source, const Options& options) : mSource(source), mOptions(options) {}

  /// Evaluates blocks in threads. Ends early, with blocks left empty, when the monitor is cancelled.
  /// @param origins  first nodes of the blocks
  std::vector<EvaluatedBlock> evaluate(std::span<const openvdb::Coord> origins, Monitor& monitor);

  std::uint64_t evaluatedNodes() const { return mEvaluated; }

 private:
  struct Scratch;
  void evaluatePart(std::span<const openvdb::Coord> origins, std::span<EvaluatedBlock> blocks, Scratch& scratch);
  void begin(const openvdb::Coord& origin, std::span<const julia::Decision> parts, EvaluatedBlock& block,
             Scratch& scratch) const;
  void queueNodes(std::span<const julia::Decision> parts, std::span<const julia::Point> at, EvaluatedBlock& block,
                  Scratch& scratch) const;
  void evaluateWaiting(Scratch& scratch);

  FieldSource mSource;
  Options mOptions;
  std::atomic<std::uint64_t> mEvaluated{0};
};

}  // namespace vdbtools
