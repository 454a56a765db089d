// SPDX-License-Identifier: Apache-2.0
/// @file undecided_blocks.h
/// The blocks of a plan that remain after large cubes of them have been proved to have one sign.
#pragma once

#include "field/block_layers.h"

#include "vdbtools/field/fractal_field.h"

namespace vdbtools {

/// Decides whether F has one sign at the nodes of cubes and at the nodes next to them. Cubes on the domain's border
/// stay undecided, because the nodes beyond it have a sign of their own.
/// @param corners  first nodes of the cubes
/// @param side     nodes along a cube's side
void decideCubes(std::span<const openvdb::Coord> corners, int side, double voxelSize, const openvdb::CoordBBox& domain,
                 const FieldSource& source, std::vector<julia::Decision>& decisions);

/// The finest level at which ball arithmetic tries to prove the sign of F. Each level is tried where the level above it
/// left the sign undecided.
enum class Proofs {
  None,
  Blocks,   ///< blocks
  Eighths,  ///< blocks, and the cubes of half their side
};

/// Appends the first nodes of a block's eighths.
void addEighths(const openvdb::Coord& origin, std::vector<openvdb::Coord>& corners);

/// The finest level at which proofs save more time than they take, judged by a sample of the blocks. It depends only on
/// the plan and the evaluator, and so do the evaluated nodes.
/// @param blocks  the plan's blocks that undecidedBlocks() leaves
Proofs worthwhileProofs(const BlockSet& blocks, const FieldPlan& plan, const FieldSource& source);

/// The plan's blocks without those in cubes of 64, 32 and 16 nodes a side whose sign is proved. F does not change sign
/// next to the removed blocks either.
BlockSet undecidedBlocks(const FieldPlan& plan, const FieldSource& source, Monitor& monitor);

}  // namespace vdbtools
