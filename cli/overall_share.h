// SPDX-License-Identifier: Apache-2.0
/// @file overall_share.h
/// How much of a whole command is done, from the phases that it goes through. A command's phases have rough weights,
/// their usual parts of its time; a phase that does not take place leaves the account as soon as a later one begins.
#pragma once

#include "vdbtools/base/phase.h"

#include <cstddef>
#include <span>
#include <string_view>

namespace cli {

struct PhaseWeight {
  vdbtools::PhaseKind phase;
  double weight;
};

/// The phases of a command in their order; of one that has none, the list is empty. @param command  as in "fractal"
std::span<const PhaseWeight> phasesOf(std::string_view command);

class OverallShare {
 public:
  /// @param phases  must outlive this
  explicit OverallShare(std::span<const PhaseWeight> phases) : mPhases(phases) {}

  /// @param phase  may be that of a piece of the work, by a NumberedMonitor; pieces count as equal
  void begin(const vdbtools::Phase& phase);

  /// From 0 to 1, and never less than before. @param fraction  of the phase at hand that is done, from 0 to 1
  double at(double fraction);

 private:
  double ofPiece(double fraction) const;

  std::span<const PhaseWeight> mPhases;
  std::size_t mNext = 0;                ///< the phase after the one at hand
  double mDone = 0, mWeight = 0;        ///< of the phases before, and of the one at hand
  std::size_t mNumber = 0, mCount = 0;  ///< of the piece, from 1; 0 where there are no pieces
  double mBeforePieces = 0;
  double mShare = 0;
};

}  // namespace cli
