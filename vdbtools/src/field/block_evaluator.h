// SPDX-License-Identifier: Apache-2.0
/// @file block_evaluator.h
/// F at the nodes of whole blocks. A block, or a part of one, whose sign is proved is not evaluated.
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
  /// Active nodes were evaluated; at some of them julia::kFieldLimit tells by its sign only that of F, unless
  /// Options::everyValue. Empty: F has one sign at all nodes of the block and at those next to it.
  std::unique_ptr<Leaf> field;
  std::unique_ptr<Leaf> iterations;  ///< if requested
  /// The sign of F, if the field is empty.
  julia::Decision decision = julia::Decision::Undecided;
};

/// A plan's field before anything is evaluated.
FractalField emptyField(const FieldPlan& plan, bool keepIterations);

/// Gives the tiles of a field the sign of the adjacent leaves.
void fillTiles(FractalField& field);

class BlockEvaluator {
 public:
  struct Options {
    double voxelSize = 0;       ///< world units
    openvdb::CoordBBox domain;  ///< nodes outside hold kFieldOutside
    openvdb::CoordBBox window;  ///< the nodes of the domain that are evaluated; others hold kFieldOutside, too
    bool keepIterations = false;
    bool everyValue = false;  ///< whether F itself is needed at every node, and not only its sign
    /// How to prove the sign of F, at nodes and those next to them, so that they can be skipped.
    Proofs proofs = Proofs::None;
  };

  BlockEvaluator(const FieldSource& source, const Options& options) : mSource(source), mOptions(options) {}

  /// How many blocks evaluate() should get at a time; 0 if their number does not matter.
  std::size_t preferredBlocks() const;

  /// Evaluates blocks in threads. Ends early, with blocks left empty, if the monitor is cancelled.
  /// @param origins  first nodes of the blocks
  std::vector<EvaluatedBlock> evaluate(std::span<const openvdb::Coord> origins, Monitor& monitor);

  std::uint64_t evaluatedNodes() const { return mEvaluated; }

 private:
  struct Scratch;
  std::vector<EvaluatedBlock> evaluateSigns(std::span<const openvdb::Coord> origins, Monitor& monitor);
  void beginSigns(const openvdb::Coord& origin, std::span<const julia::Decision> parts, EvaluatedBlock& block,
                  julia::SignBlock& signs) const;
  void decide(std::span<const openvdb::Coord> origins, std::span<EvaluatedBlock> blocks, Scratch& scratch) const;
  bool signsAreEnough() const;
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
