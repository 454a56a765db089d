// SPDX-License-Identifier: Apache-2.0
/// @file overall_share.h
/// Estimates how much of a whole command is done, from the phases that it goes through. Each phase of a command has a
/// rough weight, its usual part of the command's time. A phase that is skipped is no longer counted once a later one
/// begins.
#pragma once

#include "vdbtools/base/monitor.h"

#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

namespace cli {

struct PhaseWeight {
  vdbtools::PhaseKind phase;
  double weight;
};

/// The phases of a command in their order, with their weights; empty for a command without phases. @param command  its
/// name, such as "fractal"
std::vector<PhaseWeight> phasesOf(std::string_view command);

class OverallShare {
 public:
  explicit OverallShare(std::vector<PhaseWeight> phases) : mPhases(std::move(phases)) {}

  /// @param phase  if it belongs to one of several pieces of the work (NumberedMonitor), all pieces count equally
  void begin(const vdbtools::Phase& phase);

  /// The share of the command that is done, from 0 to 1; it never decreases. @param fraction  the done part of the
  /// current phase, from 0 to 1
  double at(double fraction);

 private:
  double ofPiece(double fraction) const;

  std::vector<PhaseWeight> mPhases;
  std::size_t mNext = 0;          ///< index of the phase after the current one
  double mDone = 0, mWeight = 0;  ///< weights of the earlier phases, and of the current one
  std::size_t mNumber = 0,
              mCount = 0;  ///< number of the current piece, from 1, and of all pieces; 0 where there are no pieces
  double mBeforePieces = 0;
  double mShare = 0;
};

}  // namespace cli
