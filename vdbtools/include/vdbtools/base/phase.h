// SPDX-License-Identifier: Apache-2.0
/// @file phase.h
/// The phases that long work goes through. A Monitor shows them, and a command weighs them to know how much is done.
#pragma once

#include <cstddef>
#include <string>
#include <utility>

namespace vdbtools {

enum class PhaseKind {
  Reading,
  Thickening,
  ClosingGaps,
  Sides,
  DistanceField,
  LocalThickness,
  WideningTheBand,
  Exponent,
  Proofs,
  Field,
  Seeds,
  FollowingTheSurface,
  Islands,
  JoiningIslands,
  Surface,
  Adapting,
  LevelSet,
  Versor,
  Attributes,
  Writing,
  Checking,
  Points,
  Gaps,
  Elimination,
  Thickness,
  ThinParts,
  Sample,
  Merging,
  MergingGrids,
  Signs,
  Slice,
  Distances,
  FirstVersor,
  Versors,
  RayTree,
  Render,
  Electrostatics,
  Monopoles,
  Potential,
  Fit,
  Measure,
  Evaluating,
};

/// "closing gaps" for PhaseKind::ClosingGaps.
const char* nameOf(PhaseKind kind);

/// A phase, as a part of all work or of one of several pieces of it.
struct Phase {
  // NOLINTNEXTLINE(google-explicit-constructor): a phase is most often its kind alone.
  Phase(PhaseKind k, std::string d = {}) : kind(k), detail(std::move(d)) {}

  PhaseKind kind;
  std::string detail;                 ///< follows the name, such as "of 0.01"
  std::string piece{};                ///< what the pieces are called, such as "frame"
  std::size_t number = 0, count = 0;  ///< of the piece, from 1; 0 where there are no pieces

  /// "closing gaps of 0.01, frame 3 of 24"
  std::string text() const;
};

}  // namespace vdbtools
