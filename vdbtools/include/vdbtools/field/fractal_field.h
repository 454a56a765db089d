// SPDX-License-Identifier: Apache-2.0
/// @file fractal_field.h
/// The room `field` evaluates the field F of a fractal over space, whole, in layers or along its surface, and edits it.
/// It uses the rooms up to `target`.
///
/// Here: the log-modulus field F on a regular lattice. Node (i, j, k) lies at (i, j, k) h in world space, so lattices
/// of one voxel size agree wherever they overlap. F < 0 inside, >= 0 outside. Only the shell is evaluated; see
/// julia/shell.h.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/field/crumbs.h"

#include "julia/evaluator.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdbtools {

/// What to evaluate: a domain, and the blocks of 8^3 nodes in it where F may change sign.
struct FieldPlan {
  openvdb::CoordBBox domain;  ///< the nodes of the domain, index space, both ends included
  /// Whether the domain may cut the set: a box was asked for, or phi ends there.
  bool bounded = false;
  double voxelSize = 0;  ///< h, world units
  /// The nodes that are evaluated: those of the domain, or a part of them. Cells that reach beyond the part are left
  /// out of the mesh. Within it, everything is as it would be for the whole domain, to the bit.
  openvdb::CoordBBox window;
  /// One voxel (i, j, k) for the block whose first node is 8 (i, j, k). F does not change sign within blocks that are
  /// not in here, nor between those and their neighbours.
  openvdb::MaskTree::Ptr blocks;
  /// The nodes at which F can be evaluated: the domain as it would be without a box.
  openvdb::CoordBBox whole{};
  std::optional<CrumbRule> crumbs{};  ///< if they are dropped
};

struct FractalField {
  /// F. Active nodes were evaluated; all others hold a constant of the right sign, outside of the domain a positive
  /// one. Unless every value was asked for, a node is julia::kFieldLimit where no more than F >= 0 is known.
  openvdb::FloatGrid::Ptr field;
  /// The steps that each evaluated node took; empty unless asked for.
  openvdb::FloatGrid::Ptr iterations;
  openvdb::CoordBBox domain;  ///< as the plan's
  bool bounded = false;       ///< as the plan's
  openvdb::CoordBBox window;  ///< as the plan's; nodes beyond have no value, unless they lie beyond the domain, too
  std::uint64_t evaluatedNodes = 0;
  std::optional<CrumbReport> crumbs;  ///< that were dropped, if the plan has it so
};

/// The evaluator of F, and the space of its points.
struct FieldSource {
  const julia::FieldEvaluator& evaluator;  ///< takes points of fractal space
  FractalSpace space;

  /// The versors at points of fractal space as vectors: their imaginary parts ([SK23] Fig. 2), or directions in R^3
  /// ([ZB25]).
  std::vector<openvdb::Vec3s> versorVectors(std::span<const julia::Point> points) const;
};

struct FractalFieldOptions {
  double voxelSize = 0;               ///< h, world units, > 0
  std::optional<openvdb::BBoxd> box;  ///< region of interest, world units
  bool keepIterations = false;        ///< as in EvaluateFieldOptions
  /// Only these nodes of the domain, which stays what it is without them.
  std::optional<openvdb::CoordBBox> window{};
};

/// For a map that has a shell: only where the exponent leaves F undecided.
/// @throw std::invalid_argument  h not positive, a lattice too large to be indexed, a box that holds no node
/// @throw DataError              the box does not touch the domain
FieldPlan planShell(const ExponentGrid& exponent, const FractalFieldOptions& options);

/// Every node of the same domain: a check on planShell(), which must agree in every sign.
FieldPlan planExhaustive(const ExponentGrid& exponent, const FractalFieldOptions& options);

/// Every node of options.box, which must be given: for maps without a shell.
FieldPlan planBox(const FractalFieldOptions& options);

/// Boxes of nodes, clipped by the plan's window, outside of which F changes no sign: around the runs of undecided
/// cells of @a exponent, or without one the whole window. In no particular order, and they overlap.
std::vector<openvdb::CoordBBox> undecidedBoxes(const ExponentGrid* exponent, const FieldPlan& plan);

struct EvaluateFieldOptions {
  bool keepIterations = false;
  /// Whether F itself is wanted, and not only its sign: evaluates every node of the plan's blocks, even where the sign
  /// is proved.
  bool everyNode = false;
};

/// The field of a plan, whole in memory, without its crumbs where the plan drops them.
FractalField evaluateField(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& options,
                           Monitor& monitor);

/// Planning and evaluating in one step.
FractalField fractalField(const FieldSource& source, const ExponentGrid& exponent, const FractalFieldOptions& options,
                          Monitor& monitor);
FractalField fractalFieldExhaustive(const FieldSource& source, const ExponentGrid& exponent,
                                    const FractalFieldOptions& options, Monitor& monitor);
FractalField fractalFieldEverywhere(const FieldSource& source, const FractalFieldOptions& options, Monitor& monitor);

}  // namespace vdbtools
