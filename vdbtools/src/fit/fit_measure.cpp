// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"
#include "vdbtools/fit/fit_job.h"

#include "base/elementary.h"
#include "base/in_parallel.h"
#include "base/openvdb/fast_sweeping.h"
#include "base/timed_part.h"
#include "fit/log_moduli.h"
#include "vdbtools/maps/map_descriptor.h"

#include "julia/rational_map.h"

#include <openvdb/tools/Dense.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools::fit {
namespace {

using julia::Point;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3s;

constexpr float kLargestLog = 20;  ///< bound of |L| on the cells, which is infinite at roots

/// The counts of one slice of the cube.
struct Tally {
  std::uint64_t both = 0, either = 0;
  double psi = 0, eta = 0;
};

double iouOf(std::uint64_t both, std::uint64_t either) {
  return either == 0 ? 0 : static_cast<double>(both) / static_cast<double>(either);
}

/// The lattice of the cells: cell (i, j, k) of the cube, x slowest; indices count from 1, because of the rim.
class Lattice {
 public:
  explicit Lattice(const FitTarget& target) : mTarget(target) {}

  std::size_t side() const { return static_cast<std::size_t>(mTarget.resolution); }
  Point position(const Vec3d& index) const {
    Point x;
    for (std::size_t axis = 0; axis < 3; ++axis)
      x[axis] =
          mTarget.cubeCentre[axis] + (index[static_cast<int>(axis)] - (mTarget.resolution + 1) / 2.0) * mTarget.cell;
    return x;
  }
  /// The centres of the cells of one slice.
  void slice(std::size_t i, std::vector<Point>& points) const {
    const std::size_t n = side();
    points.resize(n * n);
    for (std::size_t c = 0; c < n * n; ++c)
      points[c] =
          position(Vec3d(static_cast<double>(i + 1), static_cast<double>(c / n + 1), static_cast<double>(c % n + 1)));
  }
  Vec3d index(const Vec3d& nodeOfFinest) const {
    return nodeOfFinest + Vec3d((mTarget.resolution - 1) / 2 + 1);  // rounded down, see makeFitTarget()
  }

 private:
  const FitTarget& mTarget;
};

/// L of every cell, in a grid with a rim of outside cells.
struct Potential {
  std::vector<float> values;
  Tally tally;
};

Potential potentialOf(const FitTarget& target, const Lattice& lattice, const julia::Rational& rational,
                      double sharpness, Monitor& monitor) {
  const julia::RationalEvaluator<float> evaluator(rational);
  const std::size_t n = lattice.side(), rimmed = n + 2;
  Potential result;
  result.values.assign(rimmed * rimmed * rimmed, 1);
  std::vector<Tally> tallies(n);
  monitor.begin(PhaseKind::Measure, n);
  inParallel(n, 1, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<Point> points;
    std::vector<double> phi(n * n);
    std::vector<float> l(n * n);
    for (std::size_t i = begin; i != end; ++i) {
      lattice.slice(i, points);
      target.distances(points, phi);
      logModuli(evaluator, points, l);
      Tally& tally = tallies[i];
      for (std::size_t c = 0; c < n * n; ++c) {
        const bool inMap = l[c] < 0, inTarget = phi[c] < 0;
        tally.both += inMap && inTarget;
        tally.either += inMap || inTarget;
        const double w = 1 / std::copysign(std::max(std::abs(phi[c]), julia::kLeastDistance * target.cell), phi[c]);
        tally.psi -= elementary::tanh(sharpness * static_cast<double>(l[c])) * w;
        tally.eta += std::abs(w);
        result.values[((i + 1) * rimmed + c / n + 1) * rimmed + c % n + 1] =
            std::clamp(l[c], -kLargestLog, kLargestLog);
      }
      monitor.advance(1);
    }
  });
  for (const Tally& tally : tallies) {
    result.tally.both += tally.both;
    result.tally.either += tally.either;
    result.tally.psi += tally.psi;
    result.tally.eta += tally.eta;
  }
  return result;
}

FloatGrid::Ptr gridOf(std::vector<float>& values, const Lattice& lattice) {
  const int last = static_cast<int>(lattice.side()) + 1;
  const openvdb::tools::Dense<float> dense(openvdb::CoordBBox(Coord(0), Coord(last)), values.data());
  // The background differs from all values, so that all become active.
  FloatGrid::Ptr grid = FloatGrid::create(2 * kLargestLog);
  openvdb::tools::copyFromDense(dense, *grid, 0.0f);
  grid->tree().voxelizeActiveTiles();
  return grid;
}

std::vector<Vec3s> surfacePoints(const FloatGrid& grid) {
  std::vector<Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, quads, 0);
  return points;
}

struct Distances {
  double mean = std::numeric_limits<double>::infinity(), largest = std::numeric_limits<double>::infinity();
};

Distances summary(const std::vector<double>& distances) {
  if (distances.empty()) return {};
  Distances result{0, 0};
  for (const double distance : distances) {
    result.mean += std::abs(distance);
    result.largest = std::max(result.largest, std::abs(distance));
  }
  result.mean /= static_cast<double>(distances.size());
  return result;
}

/// From the map's surface to the target's.
Distances toTarget(const FitTarget& target, const Lattice& lattice, const std::vector<Vec3s>& surface) {
  std::vector<Point> points;
  for (const Vec3s& p : surface) points.push_back(lattice.position(p));
  std::vector<double> distances(points.size());
  target.distances(points, distances);
  return summary(distances);
}

/// Distances from the target's surface to the map's, computed by fast sweeping.
Distances fromTarget(const FitTarget& target, const Lattice& lattice, const FloatGrid& potential) {
  const FloatGrid::Ptr sdf = sdfOfField(potential);
  const auto accessor = sdf->getConstAccessor();
  const FloatGrid::ConstPtr finest =
      target.levels.front()->copyReplacingTransform(openvdb::math::Transform::createLinearTransform(1.0));
  std::vector<double> distances;
  for (const Vec3s& node : surfacePoints(*finest))
    distances.push_back(openvdb::tools::BoxSampler::sample(accessor, lattice.index(node)) * target.cell);
  return summary(distances);
}

}  // namespace

FitMeasure measureFit(const FitTarget& target, const julia::Rational& rational, double sharpness, Monitor& monitor) {
  if (!(sharpness > 0 && std::isfinite(sharpness)))
    throw std::invalid_argument("the sharpness is " + shortText(sharpness) + "; it must be above 0");
  const Lattice lattice(target);
  Potential potential = potentialOf(target, lattice, rational, sharpness, monitor);
  const Tally& tally = potential.tally;
  FitMeasure measure;
  measure.iou = iouOf(tally.both, tally.either);
  measure.wrongCells = tally.either - tally.both;
  measure.psi = tally.psi / tally.eta;
  const FloatGrid::Ptr grid = gridOf(potential.values, lattice);
  const std::vector<Vec3s> surface = surfacePoints(*grid);
  const Distances there = toTarget(target, lattice, surface);
  const Distances back = surface.empty() ? Distances() : fromTarget(target, lattice, *grid);
  measure.meanDistance = (there.mean + back.mean) / 2;
  measure.hausdorff = std::max(there.largest, back.largest);
  monitor.throwIfCancelled();
  return measure;
}

double iteratedIou(const FitTarget& target, const julia::Rational& rational, const IteratedOptions& options,
                   Monitor& monitor) {
  if (options.iterations < 1 || options.every < 1)
    throw std::invalid_argument("the iterations are " + std::to_string(options.iterations) + " and every cell of " +
                                std::to_string(options.every) + " counts; both must be 1 or more");
  const Lattice lattice(target);
  const std::unique_ptr<julia::FieldEvaluator> evaluator =
      makeEvaluator(Arithmetic::Double, julia::Embedding{}, {.maxIterations = options.iterations},
                    [&]<class Real>() -> std::shared_ptr<const julia::Map<Real>> {
                      return std::make_shared<julia::RationalMap<Real>>(rational);
                    });
  const std::size_t n = lattice.side(), every = static_cast<std::size_t>(options.every), first = (every - 1) / 2;
  const std::size_t slices = (n - first + every - 1) / every;
  std::vector<Tally> tallies(slices);
  monitor.begin(PhaseKind::Measure, slices);
  inParallel(slices, 1, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<Point> all, points;
    std::vector<double> phi, field;
    for (std::size_t i = begin; i != end; ++i) {
      lattice.slice(first + i * every, all);
      points.clear();
      for (std::size_t y = first; y < n; y += every)
        for (std::size_t z = first; z < n; z += every) points.push_back(all[y * n + z]);
      phi.resize(points.size());
      field.resize(points.size());
      target.distances(points, phi);
      evaluator->evaluate(points, field, {});
      for (std::size_t c = 0; c < points.size(); ++c) {
        const bool inMap = field[c] < 0, inTarget = phi[c] < 0;
        tallies[i].both += inMap && inTarget;
        tallies[i].either += inMap || inTarget;
      }
      monitor.advance(1);
    }
  });
  monitor.throwIfCancelled();
  Tally all;
  for (const Tally& tally : tallies) {
    all.both += tally.both;
    all.either += tally.either;
  }
  return iouOf(all.both, all.either);
}

double scaleShift(const FitTarget& target, const julia::Rational& rational, int iterations, Monitor& monitor) {
  if (iterations == 1) return 0;
  constexpr int kCells = 24;                           // along an axis
  constexpr double kLow = -6, kHigh = 1, kStep = 0.5;  // where it is searched first
  constexpr int kHalvings = 5;                         // of the step, about the best
  constexpr int kFirst = static_cast<int>((kHigh - kLow) / kStep) + 1;
  monitor.begin(PhaseKind::Measure, kFirst + 2 * kHalvings);
  QuietMonitor quiet(monitor);
  const IteratedOptions options{.iterations = iterations, .every = std::max(1, target.resolution / kCells)};
  const auto iouAt = [&](double shift) {
    julia::Rational shifted = rational;
    shifted.logScale += shift;
    const double iou = iteratedIou(target, shifted, options, quiet);
    monitor.throwIfCancelled();
    monitor.advance(1);
    return iou;
  };
  double best = 0, most = iouAt(0);
  const auto tryShift = [&](double shift) {
    if (const double iou = iouAt(shift); iou > most) {
      most = iou;
      best = shift;
    }
  };
  for (int i = 0; i < kFirst; ++i)
    if (const double shift = kLow + i * kStep; shift != 0) tryShift(shift);
  double step = kStep;
  for (int i = 0; i < kHalvings; ++i) {
    step /= 2;
    const double middle = best;
    tryShift(middle - step);
    tryShift(middle + step);
  }
  return best;
}

}  // namespace vdbtools::fit
