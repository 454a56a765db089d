// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/fit/fit_target.h"

#include "base/elementary.h"
#include "base/in_parallel.h"
#include "base/openvdb/level_set_filter.h"
#include "decimation/decimate.h"
#include "distance/known_distance.h"
#include "distance/united_parts.h"
#include "distance/wide_distance.h"
#include "repair/solid_input.h"
#include "vdbtools/base/text.h"
#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/surface/level_set.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

namespace vdbtools::fit {
namespace {

using julia::Point;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;

constexpr double kCubeSide = 1.2;       ///< side, relative to the box's longest side
constexpr double kKnownSide = 2;        ///< size of the region with known distances, relative to the cube's side
constexpr int kDefaultSdfVoxels = 200;  ///< voxels along the longest side, the default of `juliavdb fractal`

constexpr double kShortEdge = 0.4;  ///< in cells; shorter edges of the surface are slivers of marching cubes

constexpr std::size_t kBatch = 4096;  ///< points that a thread processes at once

void requireInDomain(const FitTargetOptions& options) {
  if (options.resolution < 8 || options.resolution > 1000)
    throw std::invalid_argument("the resolution is " + std::to_string(options.resolution) + "; it must be 8 to 1000");
  if (options.triangles < 100)
    throw std::invalid_argument("a surface of " + std::to_string(options.triangles) +
                                " triangles is too coarse; allow 100 or more");
  if (!(options.smooth >= 0 && options.smooth <= 4))
    throw std::invalid_argument("the smoothing is " + shortText(options.smooth) + " cells; it must be 0 to 4");
}

/// The shape as a mesh, and where `juliavdb fractal` places it.
struct Solid {
  Mesh mesh;
  openvdb::BBoxd box;
  std::optional<FractalSpace> space;  ///< set for a VDB; for a mesh it depends on the distances
  MendOptions mend{};
  std::map<std::string, std::string> facts{};
};

Solid readSolid(const FitTargetOptions& options, Monitor& monitor) {
  Solid solid;
  if (options.mesh || !isVdbPath(options.input)) {
    const SolidSource source = openSolid(options.input, options.mesh, options.mend);
    solid.mesh = *source.solid;
    solid.box = source.box;
    solid.mend = options.mend;
    if (source.mesh->pointsLeftOut > 0) solid.facts[kPointsLeftOut] = std::to_string(source.mesh->pointsLeftOut);
    return solid;
  }
  // Its values say what is a cavity.
  solid.mend = {.repair = options.mend.repair, .gap = options.mend.gap, .hollows = Hollows::Keep};
  Target target = readVdbTarget(options.input, options.grid, options.mend.volume, monitor);
  solid.facts = target.facts;
  solid.mesh = meshOfLevelSet(*target.phi, monitor);
  solid.box = target.box;
  if (!centreIsInside(*target.phi, target.box)) extendBand(target, 0, std::numeric_limits<double>::infinity(), monitor);
  solid.space = fitFractalSpace(*target.phi, target.box);
  return solid;
}

/// @param finest  distances that are accurate to a voxel
FractalSpace spaceOf(const Solid& solid, const FloatGrid& finest, Monitor& monitor) {
  if (solid.space) return *solid.space;
  const Vec3d middle = solid.box.getCenter();
  const double phi = openvdb::tools::BoxSampler::sample(finest.getConstAccessor(), finest.worldToIndex(middle));
  if (phi < -finest.voxelSize()[0]) return fitFractalSpace(finest, solid.box);
  // If this is too close to the surface, the lattice of `juliavdb fractal` decides; if it says outside, its deepest
  // node is used.
  const double voxel = longestSide(solid.box) / kDefaultSdfVoxels;
  const auto gridTo = [&](double depth) {
    return makeSdfAbout(middle, solid.mesh, sdfBand(voxel, kFitBand, depth), solid.mend, monitor).grid;
  };
  const FloatGrid::Ptr shallow = gridTo(kFitBand);
  if (centreIsInside(*shallow, solid.box)) return fitFractalSpace(*shallow, solid.box);
  return fitFractalSpace(*gridTo(std::numeric_limits<double>::infinity()), solid.box);
}

/// The cube's centre in the finest level's index space: with an odd number of cells it is the centre of a cell, and
/// with an even number a corner of cells; the cells' centres are nodes in both cases.
double middleNode(int resolution) { return resolution % 2 == 0 ? 0.5 : 0; }

/// The cube in which distances are known, in the index space of level @a l, equal for all axes.
struct KnownRange {
  double low, high;
};
KnownRange knownRange(const FitTarget& target, std::size_t l) {
  const double middle = middleNode(target.resolution), half = kKnownSide / 2 * target.resolution;
  return {std::ldexp(middle - half, -static_cast<int>(l)), std::ldexp(middle + half, -static_cast<int>(l))};
}

/// The nodes needed to read any point of the known cube trilinearly.
CoordBBox knownNodes(const FitTarget& target, std::size_t l) {
  const KnownRange range = knownRange(target, l);
  return {Coord(static_cast<int>(std::floor(range.low))), Coord(static_cast<int>(std::ceil(range.high)))};
}

bool knowsAll(const FloatGrid& level, const CoordBBox& nodes) {
  const auto accessor = level.getConstAccessor();
  for (auto node = nodes.begin(); node; ++node)
    if (!accessor.isValueOn(*node)) return false;
  return true;
}

/// Mean curvature flow that moves the surface by at most half of @a smooth voxels anywhere.
FloatGrid::Ptr smoothed(const FloatGrid& phi, double smooth, Monitor& monitor) {
  FloatGrid::Ptr result = phi.deepCopy();
  if (smooth == 0) return result;
  // A step corresponds to heat diffusion over a third of a voxel squared: n steps blur by a Gaussian of deviation
  // sqrt(n / 3).
  const int steps = static_cast<int>(std::ceil(3 * smooth * smooth));
  meanCurvatureFlow(*result, steps, monitor);
  const auto movedBy = [&phi](double distance) {
    FloatGrid::Ptr moved = phi.deepCopy();
    for (auto value = moved->beginValueOn(); value; ++value) value.setValue(*value - static_cast<float>(distance));
    return moved;
  };
  const double most = smooth / 2 * phi.voxelSize()[0];
  openvdb::tools::csgUnion(*result, *movedBy(-most));
  openvdb::tools::csgIntersection(*result, *movedBy(most));
  return result;
}

julia::TriangleSurface rootSurface(const FitTarget& target, const FitTargetOptions& options, Monitor& monitor) {
  monitor.begin(PhaseKind::Surface, 0);
  Mesh mesh = meshOfLevelSet(*smoothed(*target.levels.front(), options.smooth, monitor), monitor);
  for (Vec3d& point : mesh.points) {
    const Point x = target.space.toFractal(point);
    point = Vec3d(x.data());
  }
  mesh = decimated(mesh, static_cast<std::size_t>(options.triangles), kShortEdge * target.cell);
  julia::TriangleSurface surface;
  for (const Vec3d& p : mesh.points) surface.points.push_back({p[0], p[1], p[2]});
  for (const openvdb::Vec3I& t : mesh.triangles) surface.triangles.push_back({t[0], t[1], t[2]});
  monitor.throwIfCancelled();
  return surface;
}

/// Reads the levels, for use by one thread.
class Reader {
 public:
  explicit Reader(const FitTarget& target) : mTarget(target), mKnown(knownRange(target, 0)) {
    for (const FloatGrid::ConstPtr& level : target.levels) mLevels.emplace_back(level->tree());
  }

  double operator()(const Point& x) const {
    const double middle = middleNode(mTarget.resolution);
    Vec3d node;
    double beyond = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double wanted = (x[a] - mTarget.cubeCentre[a]) / mTarget.cell + middle;
      node[axis] = std::clamp(wanted, mKnown.low, mKnown.high);
      beyond += (wanted - node[axis]) * (wanted - node[axis]);
    }
    if (std::isfinite(beyond))
      for (std::size_t l = 0; l < mLevels.size(); ++l, node *= 0.5)
        if (const std::optional<double> phi = knownDistance(mLevels[l], node))
          return *phi / mTarget.space.scale + std::sqrt(beyond) * mTarget.cell;
    return std::numeric_limits<double>::quiet_NaN();  // the point is not finite
  }

  /// Central differences over half a cell to each side.
  Vec3d gradient(const Point& x) const {
    Vec3d result;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Point a = x, b = x;
      a[axis] -= mTarget.cell / 2;
      b[axis] += mTarget.cell / 2;
      result[static_cast<int>(axis)] = ((*this)(b) - (*this)(a)) / mTarget.cell;
    }
    return result;
  }

 private:
  const FitTarget& mTarget;
  KnownRange mKnown;
  std::vector<BandAccessor> mLevels;
};

std::optional<Point> moved(const Reader& phi, double cell, Point x, double distance) {
  constexpr int kMostSteps = 20;
  constexpr double kGood = 1e-3, kGoodEnough = 0.1;  // cells
  constexpr double kFlat = 0.1;  // minimum length of the gradient; below, on a medial axis, there is no direction
  double error = distance - phi(x);
  Point best = x;
  double least = std::abs(error);
  for (int step = 0; step < kMostSteps && least > kGood * cell; ++step) {
    const Vec3d gradient = phi.gradient(x);
    const double squared = gradient.lengthSqr();
    if (!(squared > kFlat * kFlat)) break;
    for (std::size_t axis = 0; axis < 3; ++axis) x[axis] += error / squared * gradient[static_cast<int>(axis)];
    error = distance - phi(x);
    if (std::abs(error) < least) {
      least = std::abs(error);
      best = x;
    }
  }
  if (!(least <= kGoodEnough * cell)) return std::nullopt;
  return best;
}

}  // namespace

double FitTarget::distance(const Point& x) const { return Reader(*this)(x); }

void FitTarget::distances(std::span<const Point> x, std::span<double> phi) const {
  inParallel(x.size(), kBatch, Monitor(), [&](std::size_t begin, std::size_t end) {
    const Reader reader(*this);
    for (std::size_t i = begin; i != end; ++i) phi[i] = reader(x[i]);
  });
}

FitTarget makeFitTarget(const FitTargetOptions& options, Monitor& monitor) {
  openvdb::initialize();
  requireInDomain(options);
  Solid solid = readSolid(options, monitor);
  FitTarget target;
  target.box = solid.box;
  target.resolution = options.resolution;
  const double voxel = kCubeSide * longestSide(solid.box) / options.resolution;
  const Vec3d node = solid.box.getCenter() - Vec3d(middleNode(options.resolution) * voxel);
  const MeshSdf sdf = makeSdfAbout(node, solid.mesh, sdfBand(voxel, kFitBand, kFitBand), solid.mend, monitor);
  const FloatGrid::Ptr finest = sdf.grid;
  target.facts = solid.facts;
  if (!solid.space) target.facts.merge(partFacts(sdf.parts, solid.mend.hollows));
  target.levels.push_back(finest);
  target.space = spaceOf(solid, *finest, monitor);
  solid.mesh = Mesh();
  target.cell = voxel / target.space.scale;
  target.cubeCentre = target.space.toFractal(solid.box.getCenter());
  monitor.begin(PhaseKind::Distances, 0);
  while (!knowsAll(*target.levels.back(), knownNodes(target, target.levels.size() - 1))) {
    target.levels.push_back(coarserBand(*target.levels.back(), kFitBand / 2));
    monitor.throwIfCancelled();
  }
  target.surface = rootSurface(target, options, monitor);
  return target;
}

std::vector<julia::FitCell> adaptiveCells(const FitTarget& target, double bandWidth) {
  if (!(bandWidth >= 1 && bandWidth <= kFitBand - 1))
    throw std::invalid_argument("the band is " + shortText(bandWidth) + " cells wide; it must be 1 to " +
                                std::to_string(kFitBand - 1));
  const double voxel = target.cell * target.space.scale, middle = middleNode(target.resolution);
  std::vector<julia::FitCell> cells;
  for (std::size_t l = 0; l < target.levels.size(); ++l) {
    const FloatGrid& level = *target.levels[l];
    const double size = elementary::exp2(l);  // cells
    const double least = l == 0 ? 0 : bandWidth * voxel * size / 2;
    const double most =
        l + 1 == target.levels.size() ? std::numeric_limits<double>::infinity() : bandWidth * voxel * size;
    const KnownRange range = knownRange(target, l);
    for (auto value = level.cbeginValueOn(); value; ++value) {
      if (!(std::abs(*value) >= least && std::abs(*value) < most)) continue;
      const Coord node = value.getCoord();
      julia::FitCell cell{{}, static_cast<float>(*value / target.space.scale), 1};
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        cell.x[a] = target.cubeCentre[a] + (node[axis] * size - middle) * target.cell;
        const double within = std::min(node[axis] + 0.5, range.high) - std::max(node[axis] - 0.5, range.low);
        cell.volume *= static_cast<float>(std::max(within, 0.0) * size);
      }
      if (cell.volume > 0) cells.push_back(cell);
    }
  }
  return cells;
}

std::vector<julia::FitCell> denseCells(const FitTarget& target, int resolution) {
  if (resolution < 1 || resolution > 1000)
    throw std::invalid_argument("the resolution is " + std::to_string(resolution) + "; it must be 1 to 1000");
  const auto side = static_cast<std::size_t>(resolution);
  const double size = static_cast<double>(target.resolution) / resolution;  // cells
  const auto position = [&](std::size_t i, std::size_t axis) {
    return target.cubeCentre[axis] + (static_cast<double>(i) - (resolution - 1) / 2.0) * size * target.cell;
  };
  std::vector<julia::FitCell> cells(side * side * side);
  inParallel(side, 1, Monitor(), [&](std::size_t begin, std::size_t end) {
    const Reader phi(target);
    for (std::size_t i = begin * side * side; i != end * side * side; ++i) {
      const Point x{position(i / side / side, 0), position(i / side % side, 1), position(i % side, 2)};
      cells[i] = {x, static_cast<float>(phi(x)), static_cast<float>(size * size * size)};
    }
  });
  return cells;
}

std::optional<Point> movedTo(const FitTarget& target, Point x, double distance) {
  return moved(Reader(target), target.cell, x, distance);
}

std::vector<Point> offsetPoints(const FitTarget& target, std::size_t count, double distance, std::uint64_t seed) {
  const std::vector<Point> onSurface = julia::blueNoise(target.surface, count, seed);
  std::vector<std::optional<Point>> found(onSurface.size());
  inParallel(onSurface.size(), 64, Monitor(), [&](std::size_t begin, std::size_t end) {
    const Reader phi(target);
    for (std::size_t i = begin; i != end; ++i) found[i] = moved(phi, target.cell, onSurface[i], distance);
  });
  std::vector<Point> points;
  for (const std::optional<Point>& point : found)
    if (point) points.push_back(*point);
  return points;
}

}  // namespace vdbtools::fit
