// SPDX-License-Identifier: Apache-2.0
/// @file schedule.h
/// Optimisation schedules as [Kim15] 4.5 writes them: "25(VFRF) 50(VFRF) 97(VF)", passes on grids of 25^3, 50^3 and
/// 97^3 cells, in that order.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace julia {

enum class FitPassKind {
  VariableCoarsened,  ///< V: C, tau and beta only
  Full,               ///< F: the powers too
  Reweighted,         ///< R: as F, with W balanced between what is captured well and what is not
};

struct FitPass {
  int resolution = 0;  ///< cells along the cube's edge, 4 to 1000
  FitPassKind kind = FitPassKind::Full;

  friend bool operator==(const FitPass&, const FitPass&) = default;
};

/// @throw std::invalid_argument  what is wrong and at which character
std::vector<FitPass> parseSchedule(std::string_view text);

/// As parseSchedule() reads it: passes of one resolution together.
std::string toString(const std::vector<FitPass>& schedule);

}  // namespace julia
