// SPDX-License-Identifier: Apache-2.0
#include "fit/kim15_fit.h"

#include "base/openvdb/fast_sweeping.h"

#include "julia/fit/cancelled.h"
#include "julia/fit/minimise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace vdbtools::fit {
namespace {

using julia::FitCell;
using julia::Point;
using julia::Rational;
using openvdb::FloatGrid;

// Where the potential is matched: the distance outside the surface (fractal space), and the number of points.
constexpr double kOffset = 0.004;
constexpr std::size_t kPotentialSamples = 4000;
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

/// The monopoles as a rational with the median of L on the surface at 0, and a change of L by about 1 per cell there:
/// the energy's step must not be saturated when the first pass begins.
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

}  // namespace

julia::SurfaceCharge surfaceCharge(const julia::TriangleSurface& surface, Monitor& monitor) {
  monitor.begin(PhaseKind::Electrostatics, 0);
  try {
    return julia::solveExteriorDirichlet(surface, {.cancelled = [&monitor] { return monitor.cancelled(); }});
  } catch (const julia::Cancelled&) {
    monitor.throwIfCancelled();
    throw;
  }
}

julia::MonopoleFit monopolesOf(const FitTarget& target, const FitOptions& options, std::size_t most, FitResult& result,
                               Monitor& monitor) {
  result.charge = surfaceCharge(target.surface, monitor);
  const std::vector<Point> samples = offsetPoints(target, kPotentialSamples, kOffset, options.seed);
  std::vector<double> potentials(samples.size());
  julia::potential(target.surface, result.charge, samples, potentials);
  monitor.begin(PhaseKind::Monopoles, 0);
  const auto cancelled = [&monitor] { return monitor.cancelled(); };
  julia::MonopoleFit fit =
      julia::fitMonopoles(target.surface, samples, potentials,
                          {.epsilon = options.epsilon, .maxCount = most, .seed = options.seed, .cancelled = cancelled});
  result.monopoles = fit.monopoles.size();
  return fit;
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
    monitor.begin({PhaseKind::Fit, stage}, 0);
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

}  // namespace vdbtools::fit
