// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/exponent_grid.h"

#include "vdbtools/grid_sampler.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;
using LeafManager = openvdb::tree::LeafManager<FloatTree>;

void requireFiniteValues(const FloatGrid& phi) {
  for (auto value = phi.tree().cbeginValueAll(); value; ++value)
    if (!std::isfinite(*value))
      throw DataError("the signed distance field '" + phi.getName() + "' holds a value that is not finite near index " +
                      std::to_string(value.getCoord()[0]) + ", " + std::to_string(value.getCoord()[1]) + ", " +
                      std::to_string(value.getCoord()[2]));
}

/// E = alpha (phi - beta) at every active node, in place.
void bake(LeafManager& leaves, const openvdb::math::Transform& transform, const FractalSpace& space,
          const ExponentGridOptions& options, Monitor& monitor) {
  monitor.begin("exponent", leaves.leafCount());
  tbb::parallel_for(leaves.leafRange(), [&](const LeafManager::LeafRange& range) {
    const auto alpha = options.alpha.reader(), beta = options.beta.reader();
    for (auto leaf = range.begin(); leaf; ++leaf) {
      if (monitor.cancelled()) return;
      for (auto value = leaf->beginValueOn(); value; ++value) {
        const Vec3d world = transform.indexToWorld(value.getCoord());
        value.setValue(static_cast<float>(alpha(world) * (*value / space.scale - beta(world))));
      }
      monitor.advance(1);
    }
  });
  monitor.throwIfCancelled();
}

/// A bound of how much E differs between two nodes that one point's reading may use: three times its largest step
/// between face neighbours for the corners of a cell, three times that for the quadratic B-spline's wider reach.
double largestDifferenceInReach(const LeafManager& leaves, julia::Interpolation interpolation) {
  tbb::enumerable_thread_specific<double> largest(0.0);
  tbb::parallel_for(leaves.leafRange(), [&](const LeafManager::LeafRange& range) {
    openvdb::tree::ValueAccessor<const FloatTree> accessor(leaves.tree());
    double& most = largest.local();
    for (auto leaf = range.begin(); leaf; ++leaf)
      for (auto value = leaf->cbeginValueOn(); value; ++value)
        for (int axis = 0; axis < 3; ++axis) {
          Coord next = value.getCoord();
          next[axis] += 1;
          float other;
          if (accessor.probeValue(next, other)) most = std::max(most, std::abs(double(other) - double(*value)));
        }
  });
  const int reach = interpolation == julia::Interpolation::Quadratic ? 3 : 1;
  return 3 * reach * *std::max_element(largest.begin(), largest.end());
}

/// m(r) of shell.h, from the nodes: one at distance d is read at points that come as near as d less a cell's diagonal,
/// or one and a half for the quadratic B-spline.
julia::RadialMaximum radialMaximum(const LeafManager& leaves, const openvdb::math::Transform& transform,
                                   const FractalSpace& space, double atOrigin, julia::Interpolation interpolation) {
  const double step = transform.voxelSize().length() / space.scale / 2;  // half a cell's diagonal
  const double reach = step * (interpolation == julia::Interpolation::Quadratic ? 3 : 2);
  const std::size_t count = static_cast<std::size_t>(std::ceil(1 / step));
  const std::vector<double> nothing(count, -std::numeric_limits<double>::infinity());
  tbb::enumerable_thread_specific<std::vector<double>> parts(nothing);
  tbb::parallel_for(leaves.leafRange(), [&](const LeafManager::LeafRange& range) {
    std::vector<double>& maximum = parts.local();
    for (auto leaf = range.begin(); leaf; ++leaf)
      for (auto value = leaf->cbeginValueOn(); value; ++value) {
        const Vec3d x = (transform.indexToWorld(value.getCoord()) - space.centre) / space.scale;
        const double nearest = std::max(0.0, x.length() - reach);
        // A hair of slack against rounding at a ball's edge.
        const std::size_t ball = static_cast<std::size_t>(std::max(0.0, std::floor(nearest / step - 1e-9)));
        if (ball < count) maximum[ball] = std::max(maximum[ball], static_cast<double>(*value));
      }
  });
  julia::RadialMaximum result{step, nothing};
  for (const std::vector<double>& part : parts)
    for (std::size_t i = 0; i < count; ++i) result.maximum[i] = std::max(result.maximum[i], part[i]);
  double running = atOrigin;
  for (double& maximum : result.maximum) running = maximum = std::max(running, maximum);
  return result;
}

/// Replaces what is farther outside the interval than any cell that touches it by a constant.
void narrowToShell(FloatGrid& grid, const julia::ShellInterval& shell, double differenceInReach) {
  const float outside = static_cast<float>(shell.upper + 1);
  const bool hasLower = std::isfinite(shell.lower);
  const float inside = hasLower ? static_cast<float>(shell.lower - 1) : -1.0f;
  openvdb::tools::changeAsymmetricLevelSetBackground(grid.tree(), outside, inside);
  LeafManager leaves(grid.tree());
  leaves.foreach ([&](FloatTree::LeafNodeType& leaf, std::size_t) {
    for (auto value = leaf.beginValueOn(); value; ++value) {
      if (*value > shell.upper + differenceInReach)
        leaf.setValueOff(value.pos(), outside);
      else if (hasLower && *value < shell.lower - differenceInReach)
        leaf.setValueOff(value.pos(), inside);
    }
  });
  openvdb::tools::pruneLevelSet(grid.tree(), outside, inside);
}

}  // namespace

Target makeTarget(FloatGrid::Ptr phi, std::optional<openvdb::BBoxd> box) {
  if (phi->activeVoxelCount() == 0) throw DataError("the signed distance field '" + phi->getName() + "' is empty");
  requireFiniteValues(*phi);
  const CoordBBox active = phi->evalActiveVoxelBoundingBox();
  Target target;
  if (active.volume() == phi->activeVoxelCount()) {
    target.denseBox = active;
    phi->tree().voxelizeActiveTiles();
  } else {
    if (!(phi->background() > 0))
      throw DataError("the signed distance field '" + phi->getName() +
                      "' is neither dense nor a narrow band: its background is " + std::to_string(phi->background()) +
                      " and must be positive, the outside");
    phi->tree().voxelizeActiveTiles();
  }
  target.box = box ? *box : insideBox(*phi);
  target.phi = std::move(phi);
  return target;
}

void extendBand(Target& target, double exteriorWidth, Monitor& monitor) {
  if (target.denseBox) return;
  const FloatGrid::Ptr phi = target.phi;
  const double voxel = phi->voxelSize()[0];
  bool solidInside = false;  // an inside that holds no distance
  for (auto value = phi->tree().cbeginValueOff(); value && !solidInside; ++value) solidInside = *value < 0;
  const double wanted = exteriorWidth + kExponentMargin * voxel;
  const bool widen = phi->background() < wanted * (1 - 1e-6);
  if (!solidInside && !widen) return;
  if (!phi->hasUniformVoxels())
    throw DataError(
        "the narrow band of '" + phi->getName() +
        "' must be widened, which needs voxels of one size in all directions; resample it, or make it dense");
  monitor.begin("widening the band", 0);
  constexpr int kSweeps = 1;  // of 8 directions each; distances about one surface need no second round
  if (solidInside) {
    const Coord extent = phi->evalActiveVoxelDim();
    const int deepest = std::min({extent[0], extent[1], extent[2]}) / 2 + 2;
    target.phi = openvdb::tools::dilateSdf(*target.phi, deepest, openvdb::tools::NN_FACE, kSweeps,
                                           openvdb::tools::FastSweepingDomain::SWEEP_LESS_THAN_ISOVALUE);
    monitor.throwIfCancelled();
  }
  if (widen)
    target.phi = openvdb::tools::dilateSdf(
        *target.phi, static_cast<int>(std::ceil((wanted - phi->background()) / voxel)),
        openvdb::tools::NN_FACE_EDGE_VERTEX, kSweeps, openvdb::tools::FastSweepingDomain::SWEEP_GREATER_THAN_ISOVALUE);
  // Sweeping touches the outermost of the values that it starts from; what was read stays what it was.
  auto accessor = target.phi->getAccessor();
  for (auto value = phi->cbeginValueOn(); value; ++value) accessor.setValue(value.getCoord(), *value);
  monitor.throwIfCancelled();
}

double exteriorReach(const ExponentGridOptions& options) {
  const double least = options.alpha.range().first;
  if (!(least > 0))
    throw std::invalid_argument("alpha is " + std::to_string(least) + " somewhere; it must be above 0 everywhere");
  return std::max(0.0, std::log(options.escapeRadius) / least + options.beta.range().second);
}

ExponentGrid exponentGrid(const Target& target, const FractalSpace& space, const ExponentGridOptions& options,
                          Monitor& monitor) {
  exteriorReach(options);  // its checks
  ExponentGrid result;
  result.space = space;
  result.interpolation = options.interpolation;
  result.denseBox = target.denseBox;
  result.grid = target.phi->deepCopy();
  result.grid->setName("exponent");
  result.grid->setGridClass(openvdb::GRID_UNKNOWN);
  result.grid->clearMetadata();
  FloatGrid& grid = *result.grid;
  const openvdb::math::Transform& transform = grid.transform();
  const double logEscape = std::log(options.escapeRadius);
  if (!target.denseBox)
    openvdb::tools::changeAsymmetricLevelSetBackground(grid.tree(), static_cast<float>(logEscape + 1), -1.0f);
  double difference;
  {
    LeafManager leaves(grid.tree());
    bake(leaves, transform, space, options, monitor);
    difference = largestDifferenceInReach(leaves, options.interpolation);
    const Vec3d origin = transform.worldToIndex(space.centre);
    const bool originInBox =
        !target.denseBox ||
        openvdb::BBoxd(target.denseBox->min().asVec3d(), target.denseBox->max().asVec3d()).isInside(origin);
    julia::RadialMaximum maximum;
    maximum.step = 1;
    // Past the faces of a dense field the nearest face's value holds; that is no farther from the origin than the point
    // itself only where the box holds the origin.
    if (originInBox)
      maximum =
          radialMaximum(leaves, transform, space, grid.tree().getValue(Coord::round(origin)), options.interpolation);
    result.shell = julia::shellInterval(maximum, options.maxIterations, options.escapeRadius);
  }
  narrowToShell(grid, result.shell, difference);
  return result;
}

template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeExponentField(const ExponentGrid& exponent) {
  CoordBBox nodes = exponent.grid->evalActiveVoxelBoundingBox();
  if (nodes.empty()) nodes = CoordBBox(Coord(0), Coord(0));
  // A narrow band is surrounded by one value; with a rim of it, the nearest node is right everywhere beyond.
  constexpr int kRim = 2;
  if (exponent.denseBox)
    nodes = *exponent.denseBox;
  else
    nodes.expand(kRim);
  const GridBricks made = makeBricks(*exponent.grid, nodes, exponent.interpolation);
  const auto position = [&](double x, double y, double z) {
    return exponent.grid->worldToIndex(exponent.space.toWorld({x, y, z})) - made.origin.asVec3d();
  };
  const Vec3d zero = position(0, 0, 0);
  const Vec3d columns[3] = {position(1, 0, 0) - zero, position(0, 1, 0) - zero, position(0, 0, 1) - zero};
  julia::BrickPlacement placement;
  for (int row = 0; row < 3; ++row) {
    const auto r = static_cast<std::size_t>(row);
    for (std::size_t column = 0; column < 3; ++column) placement.matrix[r][column] = columns[column][row];
    placement.offset[r] = zero[row];
    placement.low[r] = nodes.min()[row] - made.origin[row];
    placement.high[r] = nodes.max()[row] - made.origin[row];
  }
  return std::make_shared<julia::BrickField<Real>>(made.bricks, placement);
}

template std::shared_ptr<const julia::ScalarField<float>> makeExponentField(const ExponentGrid&);
template std::shared_ptr<const julia::ScalarField<double>> makeExponentField(const ExponentGrid&);

}  // namespace vdbtools
