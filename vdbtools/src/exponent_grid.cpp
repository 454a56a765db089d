// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/exponent_grid.h"

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

// Trilinear reading and the difference bound reach one node further than the interval; one more for rounding.
constexpr int kBandMargin = 4;  // voxels

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

/// A bound of how much E differs between two corners of any cell: three times its largest step between face neighbours.
double largestDifferenceInCell(const LeafManager& leaves) {
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
  return 3 * *std::max_element(largest.begin(), largest.end());
}

/// m(r) of shell.h, from the nodes: one at distance d takes part in cells that come as near as d less a cell's
/// diagonal.
julia::RadialMaximum radialMaximum(const LeafManager& leaves, const openvdb::math::Transform& transform,
                                   const FractalSpace& space, double atOrigin) {
  const double step = transform.voxelSize().length() / space.scale / 2;  // half a cell's diagonal
  const std::size_t count = static_cast<std::size_t>(std::ceil(1 / step));
  const std::vector<double> nothing(count, -std::numeric_limits<double>::infinity());
  tbb::enumerable_thread_specific<std::vector<double>> parts(nothing);
  tbb::parallel_for(leaves.leafRange(), [&](const LeafManager::LeafRange& range) {
    std::vector<double>& maximum = parts.local();
    for (auto leaf = range.begin(); leaf; ++leaf)
      for (auto value = leaf->cbeginValueOn(); value; ++value) {
        const Vec3d x = (transform.indexToWorld(value.getCoord()) - space.centre) / space.scale;
        const double nearest = std::max(0.0, x.length() - 2 * step);
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
void narrowToShell(FloatGrid& grid, const julia::ShellInterval& shell, double differenceInCell) {
  const float outside = static_cast<float>(shell.upper + 1);
  const bool hasLower = std::isfinite(shell.lower);
  const float inside = hasLower ? static_cast<float>(shell.lower - 1) : -1.0f;
  openvdb::tools::changeAsymmetricLevelSetBackground(grid.tree(), outside, inside);
  LeafManager leaves(grid.tree());
  leaves.foreach ([&](FloatTree::LeafNodeType& leaf, std::size_t) {
    for (auto value = leaf.beginValueOn(); value; ++value) {
      if (*value > shell.upper + differenceInCell)
        leaf.setValueOff(value.pos(), outside);
      else if (hasLower && *value < shell.lower - differenceInCell)
        leaf.setValueOff(value.pos(), inside);
    }
  });
  openvdb::tools::pruneLevelSet(grid.tree(), outside, inside);
}

/// Trilinear reading in the arithmetic of the dynamics. OpenVDB's BoxSampler would do it in the grid's 32 bits.
template <class Real>
class ExponentField final : public julia::ScalarField<Real> {
 public:
  explicit ExponentField(const ExponentGrid& exponent) : mGrid(exponent.grid), mDenseBox(exponent.denseBox) {
    const auto index = [&](double x, double y, double z) {
      return mGrid->worldToIndex(exponent.space.toWorld({x, y, z}));
    };
    const Vec3d zero = index(0, 0, 0);
    const Vec3d columns[3] = {index(1, 0, 0) - zero, index(0, 1, 0) - zero, index(0, 0, 1) - zero};
    for (int row = 0; row < 3; ++row) {
      mOffset[row] = static_cast<Real>(zero[row]);
      for (int column = 0; column < 3; ++column) mMatrix[row][column] = static_cast<Real>(columns[column][row]);
    }
  }

  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override {
    openvdb::tree::ValueAccessor<const FloatTree> accessor(mGrid->tree());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = sampleOne(accessor, x[i], y[i], z[i]);
  }

 private:
  Real sampleOne(const openvdb::tree::ValueAccessor<const FloatTree>& accessor, Real x, Real y, Real z) const {
    // Beyond this index there is background only; the bound keeps the conversion to an integer defined.
    constexpr Real kFar = Real(1 << 28);
    Coord corner;
    Real weight[3];
    for (int row = 0; row < 3; ++row) {
      Real position = mMatrix[row][0] * x + mMatrix[row][1] * y + mMatrix[row][2] * z + mOffset[row];
      if (mDenseBox)
        position = std::clamp(position, Real(mDenseBox->min()[row]), Real(mDenseBox->max()[row]));
      else
        position = std::clamp(position, -kFar, kFar);
      const Real floor = std::floor(position);
      corner[row] = static_cast<int>(floor);
      weight[row] = position - floor;
      if (mDenseBox && corner[row] == mDenseBox->max()[row] && corner[row] > mDenseBox->min()[row]) {
        // On the far face: the last cell's end, not the beginning of one that is not there.
        --corner[row];
        weight[row] = 1;
      }
    }
    const auto along = [](Real from, Real to, Real t) { return from + (to - from) * t; };
    const auto value = [&](int dx, int dy, int dz) { return Real(accessor.getValue(corner.offsetBy(dx, dy, dz))); };
    const auto edge = [&](int dx, int dy) { return along(value(dx, dy, 0), value(dx, dy, 1), weight[2]); };
    const auto face = [&](int dx) { return along(edge(dx, 0), edge(dx, 1), weight[1]); };
    return along(face(0), face(1), weight[0]);
  }

  FloatGrid::ConstPtr mGrid;
  std::optional<CoordBBox> mDenseBox;
  Real mMatrix[3][3], mOffset[3];
};

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
  const double wanted = exteriorWidth + kBandMargin * voxel;
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
    difference = largestDifferenceInCell(leaves);
    const Vec3d origin = transform.worldToIndex(space.centre);
    const bool originInBox =
        !target.denseBox ||
        openvdb::BBoxd(target.denseBox->min().asVec3d(), target.denseBox->max().asVec3d()).isInside(origin);
    julia::RadialMaximum maximum;
    maximum.step = 1;
    // Past the faces of a dense field the nearest face's value holds; that is no farther from the origin than the point
    // itself only where the box holds the origin.
    if (originInBox) maximum = radialMaximum(leaves, transform, space, grid.tree().getValue(Coord::round(origin)));
    result.shell = julia::shellInterval(maximum, options.maxIterations, options.escapeRadius);
  }
  narrowToShell(grid, result.shell, difference);
  return result;
}

template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeExponentField(const ExponentGrid& exponent) {
  return std::make_shared<ExponentField<Real>>(exponent);
}

template std::shared_ptr<const julia::ScalarField<float>> makeExponentField(const ExponentGrid&);
template std::shared_ptr<const julia::ScalarField<double>> makeExponentField(const ExponentGrid&);

}  // namespace vdbtools
