// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/fit/fit_job.h"

#include "base/elementary.h"
#include "base/in_parallel.h"
#include "base/openvdb/fast_sweeping.h"
#include "fit/log_moduli.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/target/target_input.h"

#include "julia/fit/cancelled.h"
#include "julia/fit/fast_fit.h"
#include "julia/fit/minimise.h"
#include "julia/fit/monopoles.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <random>
#include <sstream>

namespace vdbtools::fit {
namespace {

using julia::FitCell;
using julia::Point;
using julia::Rational;
using openvdb::FloatGrid;

// Where the potential is matched: so far outside the surface (fractal space), at so many points.
constexpr double kOffset = 0.004;
constexpr std::size_t kPotentialSamples = 4000;
// The fast fit: the roots it starts with as a share of those wanted, and the places on the surface, a root, where more
// may go.
constexpr double kStartShare = 0.4;
constexpr double kPlacesPerRoot = 2.5;
constexpr std::size_t kLeastPlaces = 1000;
// How far from the surface roots start, as a share of their spacing, and of a cell at least.
constexpr double kStartOffset = 0.6, kLeastOffset = 1.6;
// Distances of the other places, in that offset; a thin part has some of them only.
constexpr double kOffsets[] = {0, 0.5, -0.5, 1, -1, 2.5, -2.5};
// Cells by which every row is judged.
constexpr std::size_t kJudgedCells = 24'000;
constexpr double kAlphaOfPsi = 1;

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The same cells, each seen at a place of its own within it: on a lattice, a flat face between two layers of nodes
/// could lie anywhere.
std::vector<FitCell> jittered(const FitTarget& target, std::vector<FitCell> cells, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Point> points;
  for (const FitCell& cell : cells) {
    const double size = elementary::cbrt(double{cell.volume}) * target.cell;
    Point x = cell.x;
    // The engine's numbers are fixed by the standard, the library's distributions are not.
    for (double& coordinate : x) coordinate += size * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5);
    points.push_back(x);
  }
  std::vector<double> phi(points.size());
  target.distances(points, phi);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    cells[i].x = points[i];
    cells[i].phi = static_cast<float>(phi[i]);
  }
  return cells;
}

/// L of many points, in parallel.
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

/// Judges rationals by the same cells: those of the target's cube, fine near the surface.
class Judge {
 public:
  Judge(const FitTarget& target, const std::vector<FitCell>& cells) {
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

  void judge(const Rational& rational, FitRow& row, const Monitor& monitor) const {
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

 private:
  std::vector<FitCell> mCells;
  std::vector<double> mWeights;
  double mEta = 0;
};

/// The rows of a report, as they come.
class Report {
 public:
  Report(const FitTarget& target, const std::vector<FitCell>& cells, bool wantDistances, Monitor& monitor)
      : mTarget(target), mJudge(target, cells), mWantDistances(wantDistances), mMonitor(monitor) {}

  void add(std::string stage, double energy, const Rational& rational) {
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

  /// Distances for the last row.
  void measure(const Rational& rational) {
    if (!mWantDistances || mRows.empty()) return;
    const FitMeasure measured = measureFit(mTarget, rational, kAlphaOfPsi, mMonitor);
    mRows.back().meanDistance = measured.meanDistance;
    mRows.back().hausdorff = measured.hausdorff;
  }

  std::vector<FitRow>& rows() { return mRows; }

 private:
  const FitTarget& mTarget;
  Judge mJudge;
  bool mWantDistances;
  Monitor& mMonitor;
  std::chrono::steady_clock::time_point mStart = std::chrono::steady_clock::now();
  std::vector<FitRow> mRows;
};

/// @throw Interrupted
julia::SurfaceCharge chargeOf(const julia::TriangleSurface& surface, Monitor& monitor) {
  monitor.begin("electrostatics", 0);
  try {
    return julia::solveExteriorDirichlet(surface, {.cancelled = [&monitor] { return monitor.cancelled(); }});
  } catch (const julia::Cancelled&) {
    monitor.throwIfCancelled();
    throw;
  }
}

/// The monopoles of the target's electrostatic potential.
julia::MonopoleFit monopolesOf(const FitTarget& target, const FitOptions& options, std::size_t most, FitResult& result,
                               Monitor& monitor) {
  result.charge = chargeOf(target.surface, monitor);
  const std::vector<Point> samples = offsetPoints(target, kPotentialSamples, kOffset, options.seed);
  std::vector<double> potentials(samples.size());
  julia::potential(target.surface, result.charge, samples, potentials);
  monitor.begin("monopoles", 0);
  const auto cancelled = [&monitor] { return monitor.cancelled(); };
  julia::MonopoleFit fit =
      julia::fitMonopoles(target.surface, samples, potentials,
                          {.epsilon = options.epsilon, .maxCount = most, .seed = options.seed, .cancelled = cancelled});
  result.monopoles = fit.monopoles.size();
  return fit;
}

/// What the fit found, or else is found now.
julia::SurfaceCharge chargeOf(const FitResult& fit, Monitor& monitor) {
  return fit.charge.density.empty() ? chargeOf(fit.target.surface, monitor) : fit.charge;
}

/// The target's electrostatic potential at many points: 1 on its surface, 0 at infinity.
std::vector<double> potentialAt(const FitResult& fit, std::span<const Point> points, Monitor& monitor) {
  const julia::SurfaceCharge charge = chargeOf(fit, monitor);
  constexpr std::size_t kBatch = 4096;
  std::vector<double> result(points.size());
  monitor.begin("potential", points.size());
  for (std::size_t first = 0; first < points.size(); first += kBatch) {
    const std::size_t size = std::min(kBatch, points.size() - first);
    julia::potential(fit.target.surface, charge, points.subspan(first, size), std::span(result).subspan(first, size));
    monitor.throwIfCancelled();
    monitor.advance(size);
  }
  return result;
}

/// How far from the surface the roots of a fit start, fractal space.
double startOffset(const FitTarget& target, std::size_t roots) {
  const double spacing = std::sqrt(julia::area(target.surface) / static_cast<double>(roots));
  return std::max(kStartOffset * spacing, kLeastOffset * target.cell);
}

/// Roots on both sides of the surface by turns; where the inside is too thin for that, none.
std::vector<Point> blueNoiseStart(const FitTarget& target, const FitOptions& options) {
  const auto count = static_cast<std::size_t>(kStartShare * static_cast<double>(options.roots));
  std::vector<Point> start;
  if (count == 0) return start;
  double offset = startOffset(target, options.roots);
  for (const Point& x : julia::blueNoise(target.surface, count, options.seed)) {
    if (const std::optional<Point> moved = movedTo(target, x, offset)) start.push_back(*moved);
    offset = -offset;
  }
  return start;
}

std::vector<julia::RootCandidate> candidatesOf(const FitTarget& target, const FitOptions& options,
                                               const Monitor& monitor) {
  using Side = julia::RootCandidate::Side;
  const std::size_t places =
      std::max(kLeastPlaces, static_cast<std::size_t>(kPlacesPerRoot * static_cast<double>(options.roots)));
  const double offset = startOffset(target, options.roots);
  // Another seed than the start's: the same places again would add nothing.
  const std::vector<Point> surface = julia::blueNoise(target.surface, places, options.seed + 1);
  constexpr std::size_t kChoices = std::size(kOffsets);
  std::vector<std::optional<julia::RootCandidate>> found(surface.size() * kChoices);
  inParallel(surface.size(), 64, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = 0; k < kChoices; ++k)
        if (const std::optional<Point> x = movedTo(target, surface[i], kOffsets[k] * offset))
          found[i * kChoices + k] = {*x, kOffsets[k] == 0 ? Side::Either : kOffsets[k] < 0 ? Side::Top : Side::Bottom};
  });
  std::vector<julia::RootCandidate> candidates;
  for (const auto& candidate : found)
    if (candidate) candidates.push_back(*candidate);
  return candidates;
}

Rational runFast(const FitTarget& target, const std::vector<FitCell>& cells, const FitOptions& options, Report& report,
                 FitResult& result, Monitor& monitor) {
  julia::FastFitOptions fast;
  fast.maxRoots = options.roots;
  fast.targetIou = options.targetIou;
  fast.cellSize = target.cell;
  fast.weights = options.weights;
  fast.powerPenalty = options.powerPenalty;
  fast.seed = options.seed;
  if (options.start == FitStart::Monopoles)
    for (const julia::Monopole& monopole :
         monopolesOf(target, options, std::max<std::size_t>(1, options.roots / 2), result, monitor).monopoles)
      fast.start.push_back(monopole.position);
  else
    fast.start = blueNoiseStart(target, options);
  fast.onStep = [&](const julia::FitStep& step) {
    if (!step.roundEnds) return report.add(std::string(step.stage), step.energy, *step.rational);
    report.measure(*step.rational);
    monitor.begin("fit", 0);
  };
  fast.cancelled = [&monitor] { return monitor.cancelled(); };
  monitor.begin("fit", 0);
  const julia::FastFit fit =
      julia::fastFit(jittered(target, cells, options.seed), candidatesOf(target, options, monitor), fast);
  return fit.rational;
}

/// Whether a cell of the cube is inside the current fractal, by its signed distance from fast sweeping ([Kim15] 4.5).
std::vector<char> insideFractal(const std::vector<double>& l, int resolution) {
  FloatGrid field(std::numeric_limits<float>::max());
  FloatGrid::Accessor write = field.getAccessor();
  std::size_t i = 0;
  for (int x = 0; x < resolution; ++x)
    for (int y = 0; y < resolution; ++y)
      for (int z = 0; z < resolution; ++z, ++i) write.setValue({x, y, z}, static_cast<float>(l[i]));
  std::vector<char> inside(l.size());
  const bool anySurface = std::any_of(l.begin(), l.end(), [](double value) { return value < 0; }) &&
                          std::any_of(l.begin(), l.end(), [](double value) { return value >= 0; });
  const FloatGrid::Ptr phi = anySurface ? sdfOfField(field) : field.deepCopy();
  FloatGrid::ConstAccessor read = phi->getConstAccessor();
  i = 0;
  for (int x = 0; x < resolution; ++x)
    for (int y = 0; y < resolution; ++y)
      for (int z = 0; z < resolution; ++z, ++i) inside[i] = read.getValue({x, y, z}) < 0;
  return inside;
}

/// The monopoles as a rational whose L is 0 on the surface, in the middle, and changes by about 1 over a cell there:
/// the energy's step must not be saturated where the first pass begins.
Rational initialRational(const FitTarget& target, const julia::MonopoleFit& monopoles,
                         const std::vector<FitCell>& cells, double cellSize, const Monitor& monitor) {
  const auto median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  const std::vector<Point>& surface = target.surface.points;
  Rational rational = julia::rationalFromMonopoles(monopoles.monopoles, 1, false);
  std::vector<double> l = logModuliAt(rational, surface, monitor);
  rational.logScale = -median(l);
  std::vector<FitCell> near;
  for (const FitCell& cell : cells)
    if (std::abs(cell.phi) < cellSize) near.push_back(cell);
  double square = 0;
  for (const double value : logModuliAt(rational, pointsOf(near), monitor)) square += value * value;
  const double scale = near.empty() || !(square > 0) ? 1 : std::sqrt(static_cast<double>(near.size()) / square);
  Rational scaled = julia::rationalFromMonopoles(monopoles.monopoles, scale, true);
  l = logModuliAt(scaled, surface, monitor);
  scaled.logScale = -median(l);
  return scaled;
}

Rational runSchedule(const FitTarget& target, const FitOptions& options, Report& report, FitResult& result,
                     Monitor& monitor) {
  const julia::MonopoleFit monopoles = monopolesOf(target, options, options.roots, result, monitor);
  Rational rational;
  std::unique_ptr<julia::ShapeEnergy> energy;
  std::vector<double> weights;
  int resolution = 0;
  for (const julia::FitPass& pass : options.schedule) {
    if (pass.resolution != resolution) {
      const std::vector<FitCell> cells = denseCells(target, pass.resolution);
      const double cellSize = target.cell * target.resolution / pass.resolution;
      if (resolution == 0) rational = initialRational(target, monopoles, cells, cellSize, monitor);
      weights = julia::cellWeights(cells, options.weights, cellSize);
      energy = std::make_unique<julia::ShapeEnergy>(
          pointsOf(cells), weights, rational,
          julia::ShapeEnergyOptions{.alpha = kAlphaOfPsi, .powerPenalty = options.powerPenalty});
      resolution = pass.resolution;
    }
    const std::string stage = julia::toString({pass});
    monitor.begin(stage, 0);
    if (pass.kind == julia::FitPassKind::Reweighted) {
      std::vector<double> l(weights.size());
      energy->logModuli(rational, l);
      energy->setWeights(julia::reweighted(weights, l, kAlphaOfPsi, insideFractal(l, resolution)));
    } else {
      energy->setWeights(weights);
    }
    julia::minimise(
        *energy, rational,
        pass.kind == julia::FitPassKind::VariableCoarsened ? julia::FitVariables::Coarse : julia::FitVariables::Full,
        {.onStep = [&](double value, const Rational& now) { report.add(stage, value, now); },
         .cancelled = [&monitor] { return monitor.cancelled(); }});
    report.measure(rational);
  }
  return rational;
}

/// Median of |L / phi| in the two layers of cells about the surface.
double surfaceSlope(const Rational& rational, const std::vector<FitCell>& cells, double cellSize,
                    const Monitor& monitor) {
  std::vector<FitCell> near;
  for (const FitCell& cell : cells)
    if (std::abs(cell.phi) < 2 * cellSize && std::abs(cell.phi) > 0.5 * cellSize) near.push_back(cell);
  if (near.empty()) return 0;
  std::vector<double> slopes = logModuliAt(rational, pointsOf(near), monitor);
  for (std::size_t i = 0; i < near.size(); ++i) slopes[i] = std::abs(slopes[i] / near[i].phi);
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  return *middle;
}

std::string idleEpsilon(const OptionRun& run) {
  return run.text("start") == "monopoles" || !run.text("schedule").empty()
             ? ""
             : "it goes with --start monopoles or --schedule; give one of them too, or leave it out";
}

std::string idleOfFast(const OptionRun& run) {
  return run.text("schedule").empty() ? "" : "it is for the fast fit, and --schedule fits in another way; leave it out";
}

}  // namespace

OptionTable fitOptionTable() {
  std::vector<OptionSpec> options = {
      {.name = "input",
       .argument = "MESH|SDF.vdb",
       .help = "the target: a mesh, or a VDB that holds its signed distance"},
      {.name = "grid",
       .argument = "NAME",
       .defaultValue = "",
       .help = "which grid of the input VDB to use",
       .idle = idleWithoutVdb},
      {.name = "roots",
       .argument = "N",
       .defaultValue = "331",
       .help = "the largest number of roots, top and bottom together"},
      {.name = "target-iou",
       .argument = "X",
       .defaultValue = "1",
       .help = "fast fit: stop adding roots when the IoU of the held-out cells reaches this; 1 adds all of them",
       .idle = idleOfFast},
      {.name = "resolution",
       .argument = "N",
       .defaultValue = "97",
       .help = "cells along the edge of the cube about the target in which the map is fitted and judged"},
      {.name = "schedule",
       .argument = "S",
       .defaultValue = "",
       .help = "fit as Kim (2015) does, with passes such as \"25(VFRF) 50(VFRF) 97(VF)\": V is variable-coarsened, F "
               "full, R reweighted"},
      {.name = "start",
       .argument = "blue-noise|monopoles",
       .defaultValue = "blue-noise",
       .help = "fast fit: where the first roots are placed",
       .idle = idleOfFast},
      {.name = "epsilon",
       .argument = "E",
       .defaultValue = "0.04",
       .help = "monopoles: the relative residual up to which they have to match the electrostatic potential",
       .idle = idleEpsilon},
      {.name = "weights",
       .argument = "distance|layers",
       .defaultValue = "distance",
       .help = "the weight of a cell: 1 / distance, or 1 / layer of cells as in the program of 2015"},
      {.name = "power-penalty",
       .argument = "P",
       .help = "this times the summed powers is added to the energy; small sums make rougher sets. Default 0, and 1e-5 "
               "with --schedule, where powers would otherwise grow without end"},
      {.name = "alpha",
       .argument = "A",
       .defaultValue = "0",
       .help = "scale all powers so that the shell is as thin as --alpha of 'fractal' makes it; the shape at one "
               "iteration stays. 0 leaves the powers as they were found"},
      {.name = "smooth",
       .argument = "W",
       .defaultValue = "1",
       .help = "how much the surface that roots are placed on is smoothed, in cells"},
      {.name = "triangles",
       .argument = "N",
       .defaultValue = "5000",
       .help = "the largest number of triangles of that surface"},
      {.name = "seed",
       .argument = "S",
       .defaultValue = "1",
       .help = "the seed for the places of roots and for the cells that are held out"},
  };
  for (OptionSpec& option : mendOptionSpecs()) options.push_back(std::move(option));
  return OptionTable(std::move(options));
}

FitOptions parseFitOptions(const Recipe& recipe) {
  const OptionTable table = fitOptionTable();
  const RecipeReader reader(recipe, table);
  FitOptions options;
  if (reader.text("input").empty()) throw std::invalid_argument("no target was given: a mesh, or a VDB");
  options.target.input = reader.text("input");
  options.target.grid = reader.text("grid");
  options.target.mend = parseMendOptions(reader);
  options.target.resolution = reader.integer("resolution", 8, 1000);
  options.target.smooth = reader.number("smooth");
  if (!(options.target.smooth >= 0 && options.target.smooth <= 4)) reader.refuse("smooth", "0 to 4");
  options.target.triangles = reader.integer("triangles", 100, 1'000'000);
  options.roots = reader.integer<std::size_t>("roots", 1, 100'000);
  options.targetIou = reader.number("target-iou");
  if (!(options.targetIou > 0 && options.targetIou <= 1)) reader.refuse("target-iou", "above 0 and at most 1");
  if (const std::string schedule = reader.text("schedule"); !schedule.empty())
    options.schedule = julia::parseSchedule(schedule);
  options.start =
      reader.choice<FitStart>("start", {{"blue-noise", FitStart::BlueNoise}, {"monopoles", FitStart::Monopoles}});
  options.epsilon = reader.number("epsilon");
  if (!(options.epsilon > 0 && options.epsilon < 1)) reader.refuse("epsilon", "above 0 and below 1");
  options.weights = reader.choice<julia::CellWeights>(
      "weights", {{"distance", julia::CellWeights::InverseDistance}, {"layers", julia::CellWeights::Layers}});
  constexpr double kSchedulePenalty = 1e-5;
  options.powerPenalty = reader.has("power-penalty") ? reader.notNegative("power-penalty")
                         : options.schedule.empty()  ? 0
                                                     : kSchedulePenalty;
  options.alpha = reader.notNegative("alpha");
  options.seed = reader.integer<std::uint64_t>("seed", 0, std::numeric_limits<std::uint64_t>::max());
  return options;
}

FitResult runFit(const FitOptions& options, bool wantDistances, Monitor& monitor) {
  try {
    FitTarget target = makeFitTarget(options.target, monitor);
    const std::vector<FitCell> cells = adaptiveCells(target);
    FitResult result;
    Report report(target, cells, wantDistances, monitor);
    result.rational = options.schedule.empty() ? runFast(target, cells, options, report, result, monitor)
                                               : runSchedule(target, options, report, result, monitor);
    result.slope = surfaceSlope(result.rational, cells, target.cell, monitor);
    if (options.alpha > 0 && result.slope > 0) {
      const double factor = options.alpha / result.slope;
      result.rational.logScale *= factor;
      result.rational.top.powerScale *= factor;
      result.rational.bottom.powerScale *= factor;
      result.slope = options.alpha;
    }
    result.measure = measureFit(target, result.rational, kAlphaOfPsi, monitor);
    // Where the outside has most of the weight, all of space outside is a minimum of its own.
    if (result.measure.iou == 0)
      throw DataError("the fit ended in a map that holds nothing of the target; " +
                      std::string(options.schedule.empty()
                                      ? "allow more roots"
                                      : "weigh the cells by layers, or use the fast fit, without a schedule"));
    result.rows = std::move(report.rows());
    result.target = std::move(target);
    return result;
  } catch (const julia::Cancelled&) {
    monitor.throwIfCancelled();
    throw;
  }
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
    // The loss of the stage "roots" is another quantity than psi.
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

std::string fitToJson(const FitResult& fit, const Recipe& recipe) {
  // Less what names files.
  std::string note = "juliavdb fit";
  for (const auto& [name, value] : recipe)
    if (name != "input" && !value.empty()) note += " --" + name + (value == "true" ? "" : " " + value);
  return rationalToJson(fit.rational, note, FittedTo{fit.target.space, fit.target.box});
}

ChargedSurface chargedSurface(const FitResult& fit, Monitor& monitor) {
  const julia::TriangleSurface& surface = fit.target.surface;
  const julia::SurfaceCharge charge = chargeOf(fit, monitor);
  ChargedSurface result;
  for (const Point& point : surface.points) result.mesh.points.push_back(fit.target.space.toWorld(point));
  for (const auto& [a, b, c] : surface.triangles) result.mesh.triangles.emplace_back(a, b, c);

  // The mean of the triangles at each point, weighted by their areas.
  std::vector<double> charges(surface.points.size()), areas(charges.size());
  double whole = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto corner = [&](int i) { return openvdb::Vec3d(surface.points[surface.triangles[t][i]].data()); };
    const double area = 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).length();
    whole += area;
    for (const std::uint32_t point : surface.triangles[t]) {
      charges[point] += area * charge.density[t];
      areas[point] += area;
    }
  }
  const double even = charge.capacitance / whole;
  for (std::size_t i = 0; i < charges.size(); ++i) charges[i] = areas[i] > 0 ? charges[i] / areas[i] / even : 0;
  // Nineteen points in twenty are darker than white.
  std::vector<double> sorted = charges;
  const auto bright = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 19 / 20);
  std::nth_element(sorted.begin(), bright, sorted.end());
  result.columns = {{"colour", ColumnKind::LinearRgb}, {"charge", ColumnKind::Number}};
  for (const double value : charges) {
    const auto grey = static_cast<float>(std::clamp(value / *bright, 0.0, 1.0));
    result.values.insert(result.values.end(), {grey, grey, grey, static_cast<float>(value)});
  }
  return result;
}

std::string fitToO3d(const FitResult& fit, Monitor& monitor) {
  const FitTarget& target = fit.target;
  // The 2015 program has x fastest, the cells of a target have x slowest.
  const int n = target.resolution;
  std::vector<FitCell> cells = denseCells(target, n);
  std::vector<FitCell> ordered(cells.size());
  std::size_t i = 0;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z, ++i)
        ordered[(static_cast<std::size_t>(z) * n + static_cast<std::size_t>(y)) * n + static_cast<std::size_t>(x)] =
            cells[i];
  const std::vector<Point> points = pointsOf(ordered);
  const std::vector<double> fractal = logModuliAt(fit.rational, points, monitor);
  const std::vector<double> potential = potentialAt(fit, points, monitor);
  std::vector<double> distance;
  for (const FitCell& cell : ordered) distance.push_back(cell.phi);
  const double side = target.cell * n;
  OptimisedShape shape{{n, n, n}, target.cubeCentre, {side, side, side}, fit.rational};
  return optimisedShapeToO3d(shape, fractal, distance, potential);
}

}  // namespace vdbtools::fit
