// SPDX-License-Identifier: Apache-2.0
/// @file fractal_field.h
/// The room `field` evaluates the field F of a fractal over space (whole, in layers, or along its surface) and edits
/// it.
/// It uses the rooms up to `target`.
///
/// This header declares the log-modulus field F on a regular lattice. Node (i, j, k) lies at (i, j, k) h in world
/// space, so lattices of one voxel size coincide wherever they overlap; far from the origin, where these numbers would
/// be too large, the lattice has an origin of its own. F < 0 inside, >= 0 outside. Only the shell is evaluated; see
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
  /// Whether the domain may cut the set, because a box was requested or phi ends there.
  bool bounded = false;
  double voxelSize = 0;  ///< h, world units
  /// Where node (0, 0, 0) lies, world units. What is made of the plan lies as if this were 0, and its source too.
  openvdb::Vec3d origin{0, 0, 0};
  /// The nodes that are evaluated: all nodes of the domain, or a part of them. The mesh omits cells that reach beyond
  /// the window. Within it, everything equals the result for the whole domain, to the bit.
  openvdb::CoordBBox window;
  /// One voxel (i, j, k) for the block whose first node is 8 (i, j, k). F does not change sign within blocks that are
  /// not listed, nor between those and their neighbours.
  openvdb::MaskTree::Ptr blocks;
  /// The nodes at which F can be evaluated: the domain without the restriction to a box.
  openvdb::CoordBBox whole{};
  std::optional<CrumbRule> crumbs{};  ///< the rule for dropping crumbs; empty: they are kept
  /// Where a cap closes the set, index space: at the faces of the requested box, less than a voxel beyond the last
  /// nodes. Empty: half a voxel beyond them.
  std::optional<openvdb::BBoxd> capFaces{};
};

struct FractalField {
  /// F. Active nodes were evaluated; all others hold a constant of the right sign, which is positive outside the
  /// domain. Unless every value was requested, a node is julia::kFieldLimit, with the sign of F, if no more is known.
  openvdb::FloatGrid::Ptr field;
  /// The steps that each evaluated node took; empty unless asked for.
  openvdb::FloatGrid::Ptr iterations;
  openvdb::CoordBBox domain;  ///< as in the plan
  bool bounded = false;       ///< as in the plan
  openvdb::CoordBBox window;  ///< as in the plan; nodes outside have no value, except those outside the domain
  std::uint64_t evaluatedNodes = 0;
  std::optional<CrumbReport> crumbs;       ///< the dropped crumbs, if the plan drops them
  std::optional<openvdb::BBoxd> capFaces;  ///< as in the plan
};

/// The evaluator of F, and the space of its points.
struct FieldSource {
  const julia::FieldEvaluator& evaluator;  ///< takes points of fractal space
  FractalSpace space;

  /// The nodes of a lattice in fractal space, as toFractal() places them.
  julia::SearchLattice lattice(double voxelSize, double tolerance = 1e-3) const {
    return {.voxelSize = voxelSize,
            .centre = {space.centre[0], space.centre[1], space.centre[2]},
            .scale = space.scale,
            .tolerance = tolerance};
  }

  /// Returns the versors at points of fractal space as vectors: their imaginary parts ([SK23] Fig. 2), or directions in
  /// R^3 ([ZB25]).
  std::vector<openvdb::Vec3s> versorVectors(std::span<const julia::Point> points) const;
};

struct FractalFieldOptions {
  double voxelSize = 0;               ///< h, world units, > 0
  std::optional<openvdb::BBoxd> box;  ///< region of interest, world units
  openvdb::Vec3d origin{0, 0, 0};     ///< as FieldPlan::origin
  bool keepIterations = false;        ///< as in EvaluateFieldOptions
  /// Restricts the evaluation to these nodes, without changing the domain.
  std::optional<openvdb::CoordBBox> window{};
};

/// The origin of the lattice of these options: 0, or the node in the middle of a box whose nodes cannot be numbered
/// from 0. Lattices of one voxel size then coincide to a thousandth of a voxel.
/// @throw std::invalid_argument  positions in the box are rounded too much for voxels of this size
openvdb::Vec3d latticeOrigin(const FractalFieldOptions& options);

/// Plans a map that has a shell: only the nodes where the exponent leaves F undecided.
/// @throw std::invalid_argument  h not positive, a lattice too large to be indexed, a box that holds no node
/// @throw DataError              the box does not touch the domain
FieldPlan planShell(const ExponentGrid& exponent, const FractalFieldOptions& options);

/// Plans every node of the same domain. It serves as a check on planShell(), with which it must agree in every sign.
FieldPlan planExhaustive(const ExponentGrid& exponent, const FractalFieldOptions& options);

/// Plans every node of options.box, which must be given, for maps without a shell.
FieldPlan planBox(const FractalFieldOptions& options);

/// Boxes of nodes, clipped by the plan's window, outside of which F does not change sign. They surround the runs of
/// undecided cells of @a exponent, or cover the whole window if it is null. They are unordered and overlap.
std::vector<openvdb::CoordBBox> undecidedBoxes(const ExponentGrid* exponent, const FieldPlan& plan);

struct EvaluateFieldOptions {
  bool keepIterations = false;
  /// Whether F itself is needed, and not only its sign. If so, every node of the plan's blocks is evaluated, even where
  /// the sign is proved.
  bool everyNode = false;
};

/// Evaluates the field of a plan as a whole in memory, and drops its crumbs if the plan says so.
FractalField evaluateField(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& options,
                           Monitor& monitor);

/// Plans with planShell() and evaluates.
FractalField fractalField(const FieldSource& source, const ExponentGrid& exponent, const FractalFieldOptions& options,
                          Monitor& monitor);
FractalField fractalFieldEverywhere(const FieldSource& source, const FractalFieldOptions& options, Monitor& monitor);

}  // namespace vdbtools
