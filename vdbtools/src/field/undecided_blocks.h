// SPDX-License-Identifier: Apache-2.0
/// @file undecided_blocks.h
/// The blocks of a plan that remain once large cubes of them have been proved to have one sign.
#pragma once

#include "field/block_layers.h"

#include "vdbtools/field/fractal_field.h"

namespace vdbtools {

/// Whether F has one sign at the nodes of cubes and at the nodes next to them. Cubes on the domain's border stay
/// undecided, as the nodes beyond it have a sign of their own.
/// @param corners  first nodes of the cubes
/// @param side     nodes along a cube's side
void decideCubes(std::span<const openvdb::Coord> corners, int side, double voxelSize, const openvdb::CoordBBox& domain,
                 const FieldSource& source, std::vector<julia::Decision>& decisions);

/// How far down ball arithmetic is asked for the sign of F: each level is asked where the one above left it undecided.
enum class Proofs {
  None,
  Blocks,   ///< blocks
  Eighths,  ///< blocks, and the cubes of half their side
};

/// Appends the first nodes of a block's eighths.
void addEighths(const openvdb::Coord& origin, std::vector<openvdb::Coord>& corners);

/// The level down to which proofs save more time than they take, judged by a sample of the blocks. It depends on the
/// plan and the evaluator only, and so do the nodes that are evaluated.
/// @param blocks  those of the plan that undecidedBlocks() leaves
Proofs worthwhileProofs(const BlockSet& blocks, const FieldPlan& plan, const FieldSource& source);

/// The plan's blocks less those in cubes of 64, 32 and 16 nodes a side whose sign is proved. Next to what is left out F
/// changes no sign, as in the plan.
BlockSet undecidedBlocks(const FieldPlan& plan, const FieldSource& source, Monitor& monitor);

}  // namespace vdbtools
