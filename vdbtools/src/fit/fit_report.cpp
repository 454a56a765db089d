// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_report.h"

#include "base/elementary.h"
#include "base/in_parallel.h"
#include "fit/log_moduli.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

namespace vdbtools::fit {
namespace {

using julia::FitCell;
using julia::Point;
using julia::Rational;

// The number of cells by which every row is judged.
constexpr std::size_t kJudgedCells = 24'000;

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::vector<double> logModuliAt(const Rational& rational, std::span<const Point> points, const Monitor& monitor) {
  constexpr std::size_t kBatch = 4096;
  const julia::RationalEvaluator<float> evaluator(rational);
  std::vector<float> l(points.size());
  inParallel((points.size() + kBatch - 1) / kBatch, 1, monitor, [&](std::size_t begin, std::size_t end) {
    const std::size_t first = begin * kBatch, size = std::min(end * kBatch, points.size()) - first;
    logModuli(evaluator, points.subspan(first, size), std::span(l).subspan(first, size));
  });
  return {l.begin(), l.end()};
}

Judge::Judge(const FitTarget& target, const std::vector<FitCell>& cells) {
  const double half = target.cell * target.resolution / 2;
  const std::size_t stride = std::max<std::size_t>(1, cells.size() / kJudgedCells);
  for (std::size_t i = 0; i < cells.size(); i += stride) {
    double off = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      off = std::max(off, std::abs(cells[i].x[axis] - target.cubeCentre[axis]));
    if (off <= half) mCells.push_back(cells[i]);
  }
  mWeights = julia::cellWeights(mCells, julia::CellWeights::InverseDistance, target.cell);
  for (const double weight : mWeights) mEta += std::abs(weight);
}

void Judge::judge(const Rational& rational, FitRow& row, const Monitor& monitor) const {
  const std::vector<double> l = logModuliAt(rational, pointsOf(mCells), monitor);
  double both = 0, either = 0, psi = 0;
  for (std::size_t i = 0; i < l.size(); ++i) {
    const bool target = mCells[i].phi < 0, fractal = l[i] < 0;
    both += target && fractal ? mCells[i].volume : 0;
    either += target || fractal ? mCells[i].volume : 0;
    psi -= elementary::tanh(kAlphaOfPsi * l[i]) * mWeights[i];
  }
  row.iou = either > 0 ? both / either : 0;
  row.psi = psi / mEta;
}

Report::Report(const FitTarget& target, const std::vector<FitCell>& cells, bool wantDistances, Monitor& monitor)
    : mTarget(target), mJudge(target, cells), mWantDistances(wantDistances), mMonitor(monitor) {}

void Report::add(std::string stage, double energy, const Rational& rational) {
  FitRow row;
  row.stage = std::move(stage);
  row.step = static_cast<int>(mRows.size()) + 1;
  row.top = rational.top.roots.size();
  row.bottom = rational.bottom.roots.size();
  row.energy = energy;
  row.topPowers = julia::summedPowers(rational.top);
  row.bottomPowers = julia::summedPowers(rational.bottom);
  row.seconds = secondsSince(mStart);
  mJudge.judge(rational, row, mMonitor);
  mRows.push_back(std::move(row));
  mMonitor.advance(1);
}

void Report::measure(const Rational& rational) {
  if (!mWantDistances || mRows.empty()) return;
  const FitMeasure measured = measureFit(mTarget, rational, kAlphaOfPsi, mMonitor);
  mRows.back().meanDistance = measured.meanDistance;
  mRows.back().hausdorff = measured.hausdorff;
}

std::string fitReportCsv(std::span<const FitRow> rows) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(8);
  text << "step,stage,top_roots,bottom_roots,working_energy,psi,iou,mean_distance,hausdorff,top_powers,bottom_powers,"
          "seconds\n";
  const auto measured = [](double value) {
    std::ostringstream number;
    number.imbue(std::locale::classic());
    if (value >= 0) number << value;
    return number.str();
  };
  for (const FitRow& row : rows)
    text << row.step << ',' << row.stage << ',' << row.top << ',' << row.bottom << ',' << row.energy << ',' << row.psi
         << ',' << row.iou << ',' << measured(row.meanDistance) << ',' << measured(row.hausdorff) << ','
         << row.topPowers << ',' << row.bottomPowers << ',' << row.seconds << '\n';
  return text.str();
}

Plot fitReportPlot(std::span<const FitRow> rows) {
  PlotSeries absolute{"(psi + 1) / 2 on all weights", {}, kVermilion}, working{"(working energy + 1) / 2", {}, kBlue},
      rest{"1 \u2212 IoU", {}, kGreen};
  for (const FitRow& row : rows) {
    absolute.points.emplace_back(row.step, (row.psi + 1) / 2);
    // The loss of the stage "roots" is a different quantity from psi.
    working.points.emplace_back(row.step,
                                row.stage == "roots" ? std::numeric_limits<double>::quiet_NaN() : (row.energy + 1) / 2);
    rest.points.emplace_back(row.step, 1 - row.iou);
  }
  return {.series = {absolute, working, rest},
          .title = "Error of the fit",
          .xLabel = "step",
          .yLabel = "error",
          .logY = true};
}

}  // namespace vdbtools::fit
