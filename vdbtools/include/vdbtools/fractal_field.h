// SPDX-License-Identifier: Apache-2.0
/// @file fractal_field.h
/// The log-modulus field F on a regular lattice: node (i, j, k) lies at (i, j, k) h in world space, so that lattices of
/// one voxel size agree wherever they overlap. F < 0 inside, >= 0 outside. Only the shell is evaluated; see shell.h of
/// julia.
#pragma once

#include "vdbtools/exponent_grid.h"
#include "vdbtools/fractal_space.h"
#include "vdbtools/monitor.h"

#include "julia/evaluator.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <optional>

namespace vdbtools {

struct FractalField {
  /// F. Active nodes were evaluated; all others hold a constant of the right sign, outside of the domain a positive
  /// one.
  openvdb::FloatGrid::Ptr field;
  /// The steps that each evaluated node took; empty unless asked for.
  openvdb::FloatGrid::Ptr iterations;
  openvdb::CoordBBox domain;  ///< the nodes of the domain, index space, both ends included
  /// Whether the domain may cut the set: a box was asked for, or phi ends there.
  bool bounded = false;
  std::uint64_t evaluatedNodes = 0;
};

/// What to evaluate, and where that lies.
struct FieldSource {
  const julia::FieldEvaluator& evaluator;  ///< takes points of fractal space
  FractalSpace space;
};

struct FractalFieldOptions {
  double voxelSize = 0;               ///< h, world units, > 0
  std::optional<openvdb::BBoxd> box;  ///< region of interest, world units
  bool keepIterations = false;
};

/// F of a map that has a shell: only where the exponent leaves it undecided.
/// @throw std::invalid_argument  h not positive, a lattice too large to be indexed, a box that holds no node
/// @throw DataError              the box does not touch the domain
FractalField fractalField(const FieldSource& source, const ExponentGrid& exponent, const FractalFieldOptions& options,
                          Monitor& monitor);

/// The same domain, every node of it evaluated: to check the other one, which must agree in every sign.
FractalField fractalFieldExhaustive(const FieldSource& source, const ExponentGrid& exponent,
                                    const FractalFieldOptions& options, Monitor& monitor);

/// F at every node of options.box, which must be given: for maps without a shell.
FractalField fractalFieldEverywhere(const FieldSource& source, const FractalFieldOptions& options, Monitor& monitor);

}  // namespace vdbtools
