// SPDX-License-Identifier: Apache-2.0
/// @file candidate_scores.h
/// By how much roots at new places would lower the loss of a fit.
#pragma once

#include "julia/fit/fast_fit.h"

#include <cstddef>
#include <span>
#include <vector>

namespace julia {

/// Cells with the slope and the curvature of the loss by L, each times the cell's weight. They are padded to whole
/// blocks by cells without either.
struct CellSlopes {
  std::vector<float> x, y, z;
  std::vector<double> slope, curvature;
  double wholeCurvature = 0;
};

/// Of @a most cells that stand for all, or of all where there are no more.
/// @pre one size
CellSlopes sampledSlopes(std::span<const FitCell> cells, std::span<const double> slope,
                         std::span<const double> curvature, std::size_t most);

struct CandidateScore {
  /// The square of the loss's slope by the power over its curvature, once the constant has adapted. 0 where only a
  /// power below 0 would lower the loss.
  double gain = 0;
  std::size_t candidate = 0;
  bool bottom = false;
};

/// Finds the gains and sorts by them, the best first. Candidates whose gain is 0 keep it and are not looked at.
/// @param blur  added to squared distances from a candidate
/// @param pull  the slope of the degree's spring: a top root relaxes it, a bottom root strains it
void rankCandidates(std::span<CandidateScore> scores, std::span<const RootCandidate> candidates,
                    const CellSlopes& cells, double blur, double pull);

}  // namespace julia
