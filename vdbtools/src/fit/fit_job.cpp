// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/fit/fit_job.h"

#include "base/elementary.h"
#include "base/in_parallel.h"
#include "fit/fit_report.h"
#include "fit/kim15_fit.h"
#include "recipe/option_rows.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/target/target_input.h"

#include "julia/fit/cancelled.h"
#include "julia/fit/fast_fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

namespace vdbtools::fit {
namespace {

using julia::FitCell;
using julia::Point;
using julia::Rational;

// The fast fit: the initial roots as a fraction of the wanted ones, and the number of further candidates on the surface
// per root.
constexpr double kStartShare = 0.4;
constexpr double kPlacesPerRoot = 2.5;
constexpr std::size_t kLeastPlaces = 1000;
// The distance of the initial roots from the surface, as a fraction of their spacing, and at least this many cells.
constexpr double kStartOffset = 0.6, kLeastOffset = 1.6;
// The distances of the other candidates, in units of that offset; thin parts have only some of them.
constexpr double kOffsets[] = {0, 0.5, -0.5, 1, -1, 2.5, -2.5};

/// Shifts each cell's sample within the cell: on a lattice, the position of a flat face between two layers of nodes
/// would be undetermined.
std::vector<FitCell> jittered(const FitTarget& target, std::vector<FitCell> cells, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Point> points;
  for (const FitCell& cell : cells) {
    const double size = elementary::cbrt(double{cell.volume}) * target.cell;
    Point x = cell.x;
    // The standard specifies the engine's numbers, but not those of the library's distributions.
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

/// The charge that the fit computed, or computes it now.
julia::SurfaceCharge chargeOf(const FitResult& fit, Monitor& monitor) {
  return fit.charge.density.empty() ? surfaceCharge(fit.target.surface, monitor) : fit.charge;
}

/// The target's electrostatic potential at many points: 1 on its surface, 0 at infinity.
std::vector<double> potentialAt(const FitResult& fit, std::span<const Point> points, Monitor& monitor) {
  const julia::SurfaceCharge charge = chargeOf(fit, monitor);
  constexpr std::size_t kBatch = 4096;
  std::vector<double> result(points.size());
  monitor.begin(PhaseKind::Potential, points.size());
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

/// Places roots alternately on both sides of the surface; none where the inside is too thin.
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
  // The seed differs from that of the start, because the same places would add nothing.
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
  fast.moveRoots = options.moveRoots;
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
    monitor.begin(PhaseKind::Fit, 0);
  };
  fast.cancelled = [&monitor] { return monitor.cancelled(); };
  monitor.begin(PhaseKind::Fit, 0);
  const julia::FastFit fit =
      julia::fastFit(jittered(target, cells, options.seed), candidatesOf(target, options, monitor), fast);
  return fit.rational;
}

/// Median of |L / phi| in the two layers of cells next to the surface.
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

constexpr const char* kFast = "fast";
constexpr const char* kKim15 = "kim15";
/// The passes of [Kim15] for most of its shapes.
constexpr const char* kPaperSchedule = "25(VFRF) 50(VFRF) 97(VF)";

/// The method that is used if it is not given.
const char* defaultMethod(const Recipe& recipe) {
  const auto schedule = recipe.find("schedule");
  return schedule == recipe.end() || schedule->second.empty() ? kFast : kKim15;
}

bool isKim15(const Recipe& recipe) {
  const auto method = recipe.find("method");
  return (method == recipe.end() ? defaultMethod(recipe) : method->second) == kKim15;
}

std::string idleEpsilon(const OptionRun& run) {
  return run.text("start") == "monopoles" || run.text("method") == kKim15
             ? ""
             : "it goes with --start monopoles or --method kim15; give one of them too, or leave it out";
}

std::string idleOfFast(const OptionRun& run) {
  return run.text("method") != kKim15 ? "" : "it is for --method fast; leave it out";
}

std::string idleOfKim15(const OptionRun& run) {
  return run.text("method") == kKim15 ? "" : "it is for --method kim15; give that, or leave it out";
}

const OptionRows<FitOptions>& fitRows() {
  static const OptionRows<FitOptions> rows{
      {{.name = "input",
        .argument = "MESH|SDF.vdb",
        .help = "the target: a mesh, or a VDB that holds its signed distance or a volume"},
       withoutDefault(text([](auto& options) -> auto& { return options.target.input; }))},
      {{.name = "grid", .argument = "NAME", .help = "which grid of the input VDB to use", .idle = idleWithoutVdb},
       text([](auto& options) -> auto& { return options.target.grid; })},
      {{.name = "roots", .argument = "N", .help = "the largest number of roots, top and bottom together"},
       whole(&FitOptions::roots, std::size_t{1}, std::size_t{100'000})},
      {{.name = "target-iou",
        .argument = "X",
        .help = "method fast: stop adding roots when the IoU of the held-out cells reaches this; 1 adds all of them",
        .idle = idleOfFast},
       number(&FitOptions::targetIou, above(0, 1))},
      {{.name = "resolution",
        .argument = "N",
        .help = "cells along the edge of the cube about the target in which the map is fitted and judged"},
       whole(
           [](auto& options) -> auto& { return options.target.resolution; }, 8, 1000)},
      {{.name = "method",
        .argument = "fast|kim15",
        .help = "how to fit: fast, or as Kim (2015) does, which takes much longer",
        .defaultFor = defaultMethod,
        .defaultNote = "fast; kim15 with --schedule"},
       parsedBy(
           [](const RecipeReader& reader, const std::string& name, FitOptions& options) {
             if (chosen<bool>(name, reader.text(name), {{kFast, false}, {kKim15, true}}))
               options.schedule = julia::parseSchedule(reader.text("schedule"));
           },
           {.kind = OptionType::Kind::Choice, .words = {kFast, kKim15}})},
      {{.name = "schedule",
        .argument = "S",
        .help = "method kim15: its passes. V is variable-coarsened, F full, R reweighted",
        .defaultFor =
            [](const Recipe& recipe) {
              const auto method = recipe.find("method");
              return method != recipe.end() && method->second == kKim15 ? kPaperSchedule : "";
            },
        .defaultNote = kPaperSchedule,
        .idle = idleOfKim15},
       readByRule()},
      {{.name = "start", .help = "method fast: where the first roots are placed", .idle = idleOfFast},
       choice<FitStart>(&FitOptions::start, {{"blue-noise", FitStart::BlueNoise}, {"monopoles", FitStart::Monopoles}})},
      {{.name = "places",
        .help = "method fast: whether the roots move to better places while the energy is lowered, or stay where they "
                "were put",
        .idle = idleOfFast},
       choice<bool>(&FitOptions::moveRoots, {{"move", true}, {"keep", false}})},
      {{.name = "epsilon",
        .argument = "E",
        .help = "monopoles: the relative residual up to which they have to match the electrostatic potential",
        .idle = idleEpsilon},
       number(&FitOptions::epsilon, between(0, 1))},
      {{.name = "weights",
        .help = "the weight of a cell: 1 / distance, or 1 / layer of cells as in the program of 2015"},
       choice<julia::CellWeights>(&FitOptions::weights, {{"distance", julia::CellWeights::InverseDistance},
                                                         {"layers", julia::CellWeights::Layers}})},
      {{.name = "power-penalty",
        .argument = "P",
        .help =
            "this times the summed powers is added to the energy; small sums make rougher sets. Default 0, and 1e-5 "
            "with --method kim15, where powers would otherwise grow without end"},
       withoutDefault(number(&FitOptions::powerPenalty, atLeast(0)))},
      {{.name = "alpha",
        .argument = "A",
        .help = "scale all powers so that the shell is as thin as --alpha of 'fractal' makes it; the shape at one "
                "iteration stays. 0 leaves the powers as they were found"},
       number(&FitOptions::alpha, atLeast(0))},
      {{.name = "iterations",
        .argument = "N",
        .help = "the iterations of the set that shall have the shape: in the end C is chosen for them. The powers are "
                "those found for one iteration",
        .defaultFor = [](const Recipe& recipe) { return isKim15(recipe) ? "1" : "3"; },
        .defaultNote = "3, as of 'fractal --map rational'; 1 with --method kim15"},
       whole(&FitOptions::iterations, 1, 1000)},
      {{.name = "smooth",
        .argument = "W",
        .help = "how much the surface that roots are placed on is smoothed, in cells"},
       number(
           [](auto& options) -> auto& { return options.target.smooth; }, within(0, 4))},
      {{.name = "triangles", .argument = "N", .help = "the largest number of triangles of that surface"},
       whole(
           [](auto& options) -> auto& { return options.target.triangles; }, 100, 1'000'000)},
      {{.name = "seed",
        .argument = "S",
        .help = "the seed for the places of roots and for the cells that are held out"},
       whole(&FitOptions::seed, std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max())}};
  return rows;
}

}  // namespace

OptionTable fitOptionTable() {
  std::vector<OptionSpec> options = fitRows().specs();
  for (OptionSpec& option : mendOptionSpecs()) options.push_back(std::move(option));
  return OptionTable(std::move(options));
}

FitOptions parseFitOptions(const Recipe& recipe) {
  constexpr double kSchedulePenalty = 1e-5;
  const OptionTable table = fitOptionTable();
  const RecipeReader reader(recipe, table);
  if (reader.text("input").empty()) throw std::invalid_argument("no target was given: a mesh, or a VDB");
  FitOptions options = fitRows().read(reader);
  options.target.mend = parseMendOptions(reader);
  if (!reader.has("power-penalty") && !options.schedule.empty()) options.powerPenalty = kSchedulePenalty;
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
    if (result.measure.iou > 0) {
      result.scaleShift = scaleShift(target, result.rational, options.iterations, monitor);
      result.rational.logScale += result.scaleShift;
      result.iteratedIou = iteratedIou(target, result.rational, {.iterations = options.scored()}, monitor);
    }
    // If the outside has most of the weight, declaring all of space outside is a local minimum.
    if (result.measure.iou == 0)
      throw DataError("the fit ended in a map that holds nothing of the target; " +
                      std::string(options.schedule.empty() ? "allow more roots"
                                                           : "weigh the cells by layers, or use --method fast"));
    result.rows = std::move(report.rows());
    result.target = std::move(target);
    return result;
  } catch (const julia::Cancelled&) {
    monitor.throwIfCancelled();
    throw;
  }
}

std::string fitToJson(const FitResult& fit, const Recipe& recipe) {
  // Without the entries that name files.
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

  // The mean over the triangles at each point, weighted by their areas.
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
  // 95 % of the points are darker than white.
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
  // The program of 2015 stores x fastest, while the cells of a target store x slowest.
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
