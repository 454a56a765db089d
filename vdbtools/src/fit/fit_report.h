// SPDX-License-Identifier: Apache-2.0
/// @file fit_report.h
/// The rows of a fit's report, each judged by the same cells.
#pragma once

#include "vdbtools/fit/fit_job.h"

#include <chrono>
#include <span>
#include <string>
#include <vector>

namespace vdbtools::fit {

/// The alpha of psi by which fits are judged.
inline constexpr double kAlphaOfPsi = 1;

/// L of many points, in parallel. @throw Interrupted
std::vector<double> logModuliAt(const julia::Rational& rational, std::span<const julia::Point> points,
                                const Monitor& monitor);

/// Judges rationals by the same cells: those of the target's cube, fine near the surface.
class Judge {
 public:
  Judge(const FitTarget& target, const std::vector<julia::FitCell>& cells);

  /// Sets psi and the IoU of a row.
  void judge(const julia::Rational& rational, FitRow& row, const Monitor& monitor) const;

 private:
  std::vector<julia::FitCell> mCells;
  std::vector<double> mWeights;
  double mEta = 0;
};

/// The rows of a report, as they come.
class Report {
 public:
  /// @param target, monitor  must outlive this
  Report(const FitTarget& target, const std::vector<julia::FitCell>& cells, bool wantDistances, Monitor& monitor);

  /// @param energy  what the stage minimises
  void add(std::string stage, double energy, const julia::Rational& rational);

  /// Measures distances for the last row, if they are wanted.
  void measure(const julia::Rational& rational);

  std::vector<FitRow>& rows() { return mRows; }

 private:
  const FitTarget& mTarget;
  Judge mJudge;
  bool mWantDistances;
  Monitor& mMonitor;
  std::chrono::steady_clock::time_point mStart = std::chrono::steady_clock::now();
  std::vector<FitRow> mRows;
};

}  // namespace vdbtools::fit
