// SPDX-License-Identifier: Apache-2.0
/// @file candidate_scores.h
/// Estimates how much roots at new places would lower the loss of a fit.
#pragma once

#include "julia/fit/fast_fit.h"

#include <cstddef>
#include <span>
#include <vector>

namespace julia {

/// Cells with the slope and the curvature of the loss with respect to L, both multiplied by the cell's weight. Cells
/// with zero slope and curvature pad them to whole blocks.
struct CellSlopes {
  std::vector<float> x, y, z;
  std::vector<double> slope, curvature;
  double wholeCurvature = 0;
};

/// Samples at most @a most cells that represent all cells.
/// @pre all spans have the same size
CellSlopes sampledSlopes(std::span<const FitCell> cells, std::span<const double> slope,
                         std::span<const double> curvature, std::size_t most);

struct CandidateScore {
  /// The squared slope of the loss with respect to the power, divided by the curvature, with the constant adapted. 0 if
  /// only a negative power would lower the loss.
  double gain = 0;
  std::size_t candidate = 0;
  bool bottom = false;
};

/// Computes the gains and sorts by them in descending order. Candidates whose gain is 0 are skipped and keep it.
/// @param blur  added to squared distances from a candidate
/// @param pull  the slope of the degree penalty: a top root reduces the penalty, a bottom root increases it
void rankCandidates(std::span<CandidateScore> scores, std::span<const RootCandidate> candidates,
                    const CellSlopes& cells, double blur, double pull);

}  // namespace julia
