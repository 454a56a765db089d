// SPDX-License-Identifier: Apache-2.0
/// @file schedule.h
/// Optimisation schedules in the notation of [Kim15] 4.5: "25(VFRF) 50(VFRF) 97(VF)" stands for passes on grids of
/// 25^3, 50^3 and 97^3 cells, in that order.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace julia {

enum class FitPassKind {
  VariableCoarsened,  ///< V: C, tau and beta only
  Full,               ///< F: the powers as well
  Reweighted,         ///< R: like F, with W balanced between the well-captured and the poorly captured regions
};

struct FitPass {
  int resolution = 0;  ///< cells along the cube's edge, from 4 to 1000
  FitPassKind kind = FitPassKind::Full;

  friend bool operator==(const FitPass&, const FitPass&) = default;
};

/// Parses a schedule. @throw std::invalid_argument  says what is wrong and at which character
std::vector<FitPass> parseSchedule(std::string_view text);

/// Returns the text that parseSchedule() reads, with passes of the same resolution grouped.
std::string toString(const std::vector<FitPass>& schedule);

}  // namespace julia
