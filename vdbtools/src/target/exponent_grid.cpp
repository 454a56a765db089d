// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/exponent_grid.h"

#include "base/elementary.h"
#include "base/grid_memory.h"
#include "base/in_parallel.h"
#include "base/openvdb/fast_sweeping.h"
#include "target/band_growth.h"
#include "target/cell_corners.h"
#include "target/exponent_law.h"
#include "target/lattice_field.h"
#include "vdbtools/base/number_text.h"
#include "vdbtools/target/fit_space.h"
#include "vdbtools/target/grid_sampler.h"

#include "julia/detail.h"

#include <openvdb/tools/Morphology.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/ValueAccessor.h>

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;
using Leaf = FloatTree::LeafNodeType;

void requireFiniteValues(const FloatGrid& phi) {
  const auto refuse = [&](const Coord& node) {
    throw DataError("the signed distance field '" + phi.getName() + "' holds a value that is not finite near index " +
                    std::to_string(node[0]) + ", " + std::to_string(node[1]) + ", " + std::to_string(node[2]));
  };
  for (auto leaf = phi.tree().cbeginLeaf(); leaf; ++leaf) {
    const float* values = leaf->buffer().data();
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i)
      if (!std::isfinite(values[i])) refuse(leaf->offsetToGlobalCoord(i));
  }
  auto tile = phi.tree().cbeginValueAll();
  tile.setMaxDepth(FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile)
    if (!std::isfinite(*tile)) refuse(tile.getCoord());
}

using Accessor = openvdb::tree::ValueAccessor<const FloatTree>;

/// Runs body(i) for every i below count, in threads, until the work is cancelled.
template <class Body>
void forEach(std::size_t count, Monitor& monitor, const Body& body) {
  inParallel(count, 16, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) body(i);
    monitor.advance(end - begin);
  });
}

std::vector<const Leaf*> leavesOf(const FloatTree& tree) {
  std::vector<const Leaf*> leaves;
  leaves.reserve(tree.leafCount());
  tree.getNodes(leaves);
  return leaves;
}

// Bit z of a row along z, in a form that compilers vectorise.
constexpr unsigned kBit[Leaf::DIM] = {1, 2, 4, 8, 16, 32, 64, 128};

/// The largest |difference| between a leaf's nodes and their face neighbours behind, where both are active.
float largestStepOf(const CellCorners& corners) {
  constexpr unsigned kSide = CellCorners::kSide;
  float most[kSide] = {};
  for (unsigned x = 0; x < kSide; ++x)
    for (unsigned y = 0; y < kSide; ++y) {
      const float* const here = corners.row(x, y);
      const unsigned on = corners.active(x, y);
      const auto include = [&](const float* other, unsigned otherOn) {
        const unsigned both = on & otherOn;
        for (unsigned z = 0; z < kSide; ++z) {
          const float step = both & kBit[z] ? std::abs(other[z] - here[z]) : 0;
          most[z] = step > most[z] ? step : most[z];
        }
      };
      include(corners.row(x + 1, y), corners.active(x + 1, y));
      include(corners.row(x, y + 1), corners.active(x, y + 1));
      include(here + 1, on >> 1);
    }
  return *std::max_element(most, most + kSide);
}

/// The largest value of an active node of the leaf, or beside its active nodes, that has an inactive negative face
/// neighbour; -inf: there is none.
float solidBeginsIn(const CellCorners& corners) {
  constexpr unsigned kSide = CellCorners::kSide;
  float most = -std::numeric_limits<float>::infinity();
  for (unsigned x = 0; x < kSide; ++x)
    for (unsigned y = 0; y < kSide; ++y) {
      const float* const here = corners.row(x, y);
      const unsigned on = corners.active(x, y);
      const auto include = [&](const float* other, unsigned otherOn) {
        for (unsigned differ = (on ^ otherOn) & 0xff; differ != 0; differ &= differ - 1) {
          const auto z = static_cast<unsigned>(std::countr_zero(differ));
          const bool isOn = on >> z & 1;
          const float active = isOn ? here[z] : other[z], inactive = isOn ? other[z] : here[z];
          if (inactive < 0) most = std::max(most, active);
        }
      };
      include(corners.row(x + 1, y), corners.active(x + 1, y));
      include(corners.row(x, y + 1), corners.active(x, y + 1));
      include(here + 1, on >> 1);
    }
  return most;
}

/// The largest value of an active node; -inf if there is none.
float greatestOf(const Leaf& leaf) {
  constexpr float kNone = -std::numeric_limits<float>::infinity();
  float most[Leaf::DIM];
  std::fill_n(most, Leaf::DIM, kNone);
  for (openvdb::Index row = 0; row < Leaf::DIM * Leaf::DIM; ++row) {
    const float* const values = leaf.buffer().data() + row * Leaf::DIM;
    const unsigned on = activeInRow(leaf, row);
    for (unsigned z = 0; z < Leaf::DIM; ++z) {
      const float value = on & kBit[z] ? values[z] : kNone;
      most[z] = value > most[z] ? value : most[z];
    }
  }
  return *std::max_element(most, most + Leaf::DIM);
}

/// Whether the leaf and its three neighbours behind it hold active nodes only.
bool isDenseThere(const Leaf& leaf, const Accessor& accessor) {
  if (!leaf.isDense()) return false;
  for (int axis = 0; axis < 3; ++axis) {
    Coord next = leaf.origin();
    next[axis] += static_cast<int>(Leaf::DIM);
    const Leaf* neighbour = accessor.probeConstLeaf(next);
    if (!neighbour || !neighbour->isDense()) return false;
  }
  return true;
}

/// Where the distances inside end and the solid begins, whose nodes say no more than that they are inside.
/// @return  the largest value of an active node that has an inactive negative neighbour; -inf: nowhere
float solidBeginsAt(const FloatGrid& grid, Monitor& monitor) {
  const std::vector<const Leaf*> leaves = leavesOf(grid.tree());
  constexpr float kNever = -std::numeric_limits<float>::infinity();
  tbb::enumerable_thread_specific<float> begins(kNever);
  forEach(leaves.size(), monitor, [&](std::size_t i) {
    const Accessor accessor(grid.tree());
    float& most = begins.local();
    // A solid tile before the leaf has no pairs of its own.
    for (int axis = 0; axis < 3; ++axis) {
      Coord before = leaves[i]->origin();
      --before[axis];
      if (accessor.probeConstLeaf(before) || !(accessor.getValue(before) < 0)) continue;
      for (auto value = leaves[i]->cbeginValueOn(); value; ++value)
        if (value.getCoord()[axis] == leaves[i]->origin()[axis]) most = std::max(most, *value);
    }
    if (isDenseThere(*leaves[i], accessor)) return;
    most = std::max(most, solidBeginsIn(CellCorners(*leaves[i], accessor)));
  });
  return *std::max_element(begins.begin(), begins.end());
}

/// A bound of how much active face neighbours differ.
double largestStep(const FloatTree& tree, Monitor& monitor) {
  const std::vector<const Leaf*> leaves = leavesOf(tree);
  tbb::enumerable_thread_specific<float> largest(0.0f);
  forEach(leaves.size(), monitor, [&](std::size_t i) {
    float& most = largest.local();
    most = std::max(most, largestStepOf(CellCorners(*leaves[i], Accessor(tree))));
  });
  constexpr double kRounding = 1 + 1e-6;
  return kRounding * *std::max_element(largest.begin(), largest.end());
}

/// The leaves that hold nodes of the band, of the whole inside where this is asked for, and layers of leaves around.
openvdb::MaskGrid::Ptr sweepingMask(const FloatGrid& phi, const BandGrowth& growth) {
  // One voxel a leaf.
  openvdb::MaskTree coarse;
  for (auto leaf = phi.tree().cbeginLeaf(); leaf; ++leaf)
    if (!leaf->isEmpty() || growth.wholeInside) coarse.setValueOn(leaf->origin() >> Leaf::LOG2DIM);
  if (growth.wholeInside) {
    auto tile = phi.tree().cbeginValueAll();
    tile.setMaxDepth(FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
      const CoordBBox box = tile.getBoundingBox();
      if (*tile < 0) coarse.fill({box.min() >> Leaf::LOG2DIM, box.max() >> Leaf::LOG2DIM}, true);
    }
  }
  requireRoomForLeaves(phi, static_cast<double>(coarse.activeVoxelCount()));
  if (growth.leaves > 0)
    openvdb::tools::dilateActiveValues(coarse, growth.leaves, openvdb::tools::NN_FACE_EDGE_VERTEX,
                                       openvdb::tools::EXPAND_TILES);
  requireRoomForLeaves(phi, static_cast<double>(coarse.activeVoxelCount()));
  coarse.voxelizeActiveTiles();
  auto mask = openvdb::MaskGrid::create();
  mask->setTransform(phi.transform().copy());
  for (auto place = coarse.cbeginValueOn(); place; ++place)
    mask->tree().touchLeaf(place.getCoord() << Leaf::LOG2DIM)->setValuesOn();
  return mask;
}

/// How many steps between face neighbours lie between two nodes that one point's reading may use: three for the corners
/// of a cell, three times that for the quadratic B-spline's wider reach.
int stepsInReach(julia::Interpolation interpolation) {
  return interpolation == julia::Interpolation::Quadratic ? 9 : 3;
}

/// E on the nodes of phi, and what is found out about it.
class Baker {
 public:
  Baker(const Target& target, const FractalSpace& space, const ExponentGridOptions& options, Monitor& monitor)
      : mSpace(space),
        mOptions(options),
        mLaw(options, space.scale, target.phi->voxelSize()[0]),
        mMonitor(monitor),
        mTransform(target.phi->transform()) {
    const std::vector<const Leaf*> leaves = leavesOf(target.phi->tree());
    mLeaves.resize(leaves.size());
    monitor.begin("exponent", 2 * leaves.size());
    try {
      forEach(leaves.size(), monitor, [&](std::size_t i) { mLeaves[i] = bake(*leaves[i]); });
    } catch (...) {
      for (Leaf* leaf : mLeaves) delete leaf;
      throw;
    }
    for (Leaf* leaf : mLeaves) mTree.addLeaf(leaf);
  }

  double largestStep() const { return vdbtools::largestStep(mTree, mMonitor); }
  const ExponentLaw& law() const { return mLaw; }

  /// How far the nodes of a leaf are from its middle at most, world units.
  double leafRadius() const {
    constexpr double kHalf = 0.5 * (Leaf::DIM - 1);
    const Vec3d zero = mTransform.indexToWorld(Vec3d(0));
    double most = 0;
    for (const double y : {-kHalf, kHalf})
      for (const double z : {-kHalf, kHalf})
        most = std::max(most, (mTransform.indexToWorld(Vec3d(kHalf, y, z)) - zero).length());
    return most;
  }
  /// Half a cell's diagonal, units of fractal space.
  double radialStep() const { return mTransform.voxelSize().length() / mSpace.scale / 2; }
  /// A node at distance d is read at points that come as near as d less a cell's diagonal, or one and a half for the
  /// quadratic B-spline.
  double radialReach() const {
    return radialStep() * (mOptions.interpolation == julia::Interpolation::Quadratic ? 3 : 2);
  }

  /// m(r) of shell.h about @a origin, world units, from the nodes.
  julia::RadialMaximum radialMaximum(const Vec3d& origin, double atOrigin) const {
    constexpr double kNone = -std::numeric_limits<double>::infinity();
    const double step = radialStep(), reach = radialReach();
    const std::size_t count = static_cast<std::size_t>(std::ceil(1 / step));
    // The ball that a distance from the origin, units of fractal space, belongs to. A hair of slack against rounding at
    // a ball's edge.
    const auto ballAt = [=](double distance) { return (distance - reach) / step - 1e-9; };
    // Nearest leaves first: the others seldom hold more than what is nearer than they are.
    const double radius = leafRadius();
    std::vector<std::pair<double, std::size_t>> order(mLeaves.size());
    for (std::size_t i = 0; i < mLeaves.size(); ++i) {
      const Vec3d middle = mTransform.indexToWorld(mLeaves[i]->origin().asVec3d() + Vec3d(0.5 * (Leaf::DIM - 1)));
      const double nearest = ballAt(((middle - origin).length() - radius) / mSpace.scale * (1 - 1e-6)) - 1;
      order[i] = {std::max(0.0, nearest), i};
    }
    std::sort(order.begin(), order.end());
    const std::vector<double> nothing(count, kNone);
    tbb::enumerable_thread_specific<std::vector<double>> parts(nothing);
    forEach(mLeaves.size(), mMonitor, [&](std::size_t i) {
      const auto& [first, number] = order[i];
      if (!(first < static_cast<double>(count))) return;
      std::vector<double>& maximum = parts.local();
      const auto known = maximum.begin() + static_cast<std::ptrdiff_t>(first);
      const Leaf& leaf = *mLeaves[number];
      if (static_cast<double>(greatestOf(leaf)) <= *std::max_element(maximum.begin(), known + 1)) return;
      const Axes at(leaf.origin(), mTransform);
      const float* values = leaf.buffer().data();
      for (openvdb::Index row = 0; row < Leaf::SIZE; row += Leaf::DIM) {
        double ball[Leaf::DIM];
        const Vec3d base = (at.x[row / Leaf::DIM / Leaf::DIM] + at.y[row / Leaf::DIM % Leaf::DIM] - origin);
        for (unsigned z = 0; z < Leaf::DIM; ++z) {
          const double x = (base[0] + at.z[z][0]) / mSpace.scale, y = (base[1] + at.z[z][1]) / mSpace.scale,
                       w = (base[2] + at.z[z][2]) / mSpace.scale;
          ball[z] = ballAt(std::sqrt(x * x + y * y + w * w));
        }
        const unsigned on = activeInRow(leaf, row / Leaf::DIM);
        for (unsigned z = 0; z < Leaf::DIM; ++z) {
          if (!(on >> z & 1) || !(ball[z] < static_cast<double>(count))) continue;
          double& most = maximum[static_cast<std::size_t>(std::max(0.0, ball[z]))];
          most = std::max(most, static_cast<double>(values[row + z]));
        }
      }
    });
    julia::RadialMaximum result{step, nothing};
    for (const std::vector<double>& part : parts)
      for (std::size_t i = 0; i < count; ++i) result.maximum[i] = std::max(result.maximum[i], part[i]);
    double running = atOrigin;
    for (double& maximum : result.maximum) running = maximum = std::max(running, maximum);
    return result;
  }

  /// From the place in the shell of detail to E.
  void stretch(const julia::DetailLaw& law) {
    forEach(mLeaves.size(), mMonitor, [&](std::size_t i) {
      for (auto value = mLeaves[i]->beginValueOn(); value; ++value)
        value.setValue(static_cast<float>(law.at(static_cast<double>(*value))));
    });
  }

  /// The grid, what is farther outside the interval than any cell that touches it replaced by a constant.
  FloatGrid::Ptr narrowed(const julia::ShellInterval& shell, double differenceInReach) {
    const float outside = static_cast<float>(shell.upper + 1);
    const bool hasLower = std::isfinite(shell.lower);
    const float inside = hasLower ? static_cast<float>(shell.lower - 1) : -1.0f;
    const double highest = shell.upper + differenceInReach,
                 lowest = hasLower ? shell.lower - differenceInReach : -std::numeric_limits<double>::infinity();
    std::vector<std::uint8_t> keeps(mLeaves.size());
    forEach(mLeaves.size(), mMonitor, [&](std::size_t i) {
      Leaf& leaf = *mLeaves[i];
      float* values = leaf.buffer().data();
      for (openvdb::Index row = 0; row < Leaf::DIM * Leaf::DIM; ++row) {
        const unsigned on = activeInRow(leaf, row);
        unsigned stays = 0;
        for (unsigned z = 0; z < Leaf::DIM; ++z) {
          float& value = values[row * Leaf::DIM + z];
          const bool active = on >> z & 1, kept = active && value <= highest && value >= lowest;
          stays |= static_cast<unsigned>(kept) << z;
          if (!kept) value = (active ? value > highest : !(value < 0)) ? outside : inside;
        }
        leaf.getValueMask().getWord<openvdb::Byte>(row) = static_cast<openvdb::Byte>(stays);
      }
      keeps[i] = !leaf.isEmpty();
    });
    FloatGrid::Ptr grid = FloatGrid::create(outside);
    grid->setTransform(mTransform.copy());
    grid->setName("exponent");
    for (std::size_t i = 0; i < mLeaves.size(); ++i)
      if (keeps[i]) grid->tree().addLeaf(mTree.stealNode<Leaf>(mLeaves[i]->origin(), outside, false));
    openvdb::tools::signedFloodFillWithValues(grid->tree(), outside, inside);
    return grid;
  }

 private:
  /// The world positions of a leaf's nodes, as sums of one part an axis; the first holds the offset.
  struct Axes {
    Axes(const Coord& origin, const openvdb::math::Transform& transform) {
      const Vec3d zero = transform.indexToWorld(Vec3d(0));
      for (int k = 0; k < static_cast<int>(Leaf::DIM); ++k) {
        x[k] = transform.indexToWorld(Vec3d(origin[0] + k, 0, 0));
        y[k] = transform.indexToWorld(Vec3d(0, origin[1] + k, 0)) - zero;
        z[k] = transform.indexToWorld(Vec3d(0, 0, origin[2] + k)) - zero;
      }
    }
    Vec3d x[Leaf::DIM], y[Leaf::DIM], z[Leaf::DIM];
  };

  /// What the law makes of phi. Inactive nodes keep a value of phi's sign.
  Leaf* bake(const Leaf& phi) const {
    auto leaf = std::make_unique<Leaf>(phi);
    float* values = leaf->buffer().data();
    if (mLaw.isUniform()) {
      for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) values[i] = mLaw.uniform(values[i]);
    } else {
      std::vector<Vec3d> points;
      std::vector<float> active;
      points.reserve(leaf->onVoxelCount());
      active.reserve(leaf->onVoxelCount());
      for (auto value = leaf->cbeginValueOn(); value; ++value) {
        points.push_back(mTransform.indexToWorld(value.getCoord()));
        active.push_back(*value);
      }
      mLaw.apply(points, active);
      std::size_t i = 0;
      for (auto value = leaf->beginValueOn(); value; ++value, ++i) value.setValue(active[i]);
    }
    for (auto value = leaf->beginValueOff(); value; ++value)
      value.setValue(phi.getValue(value.pos()) < 0 ? -1.0f : 1.0f);
    return leaf.release();
  }

  FractalSpace mSpace;
  const ExponentGridOptions& mOptions;
  ExponentLaw mLaw;
  Monitor& mMonitor;
  const openvdb::math::Transform& mTransform;
  FloatTree mTree{1.0f};
  std::vector<Leaf*> mLeaves;  // mTree's
};

}  // namespace

Target makeTarget(FloatGrid::Ptr phi, std::optional<openvdb::BBoxd> box) {
  if (phi->activeVoxelCount() == 0) throw DataError("the signed distance field '" + phi->getName() + "' is empty");
  requireFiniteValues(*phi);
  const CoordBBox active = phi->evalActiveVoxelBoundingBox();
  Target target;
  if (active.volume() == phi->activeVoxelCount()) {
    target.denseBox = active;
  } else if (!(phi->background() > 0)) {
    throw DataError("the signed distance field '" + phi->getName() +
                    "' is neither dense nor a narrow band: its background is " + shortText(phi->background()) +
                    " and must be positive, the outside");
  }
  // What has no inside is refused before its tiles take memory as voxels. Without tiles, insideBox() sees it below.
  if (!box && phi->tree().activeTileCount() > 0) insideNodeBox(*phi);
  voxelizeActiveTiles(*phi);
  target.box = box ? *box : insideBox(*phi);
  target.phi = std::move(phi);
  return target;
}

std::optional<BandGrowth> bandGrowth(const Target& target, double exteriorWidth, double interiorWidth,
                                     Monitor& monitor) {
  if (target.denseBox) return std::nullopt;
  const FloatGrid::Ptr phi = target.phi;
  const double voxel = phi->voxelSize()[0];
  const double wanted = exteriorWidth + kExponentMargin * voxel, wantedInside = interiorWidth + kExponentMargin * voxel;
  const bool widen = phi->background() < wanted * (1 - 1e-6);
  const double known = -solidBeginsAt(*phi, monitor);
  const bool deepen = known < wantedInside * (1 - 1e-6);
  if (!deepen && !widen) return std::nullopt;
  if (!phi->hasUniformVoxels())
    throw DataError(
        "the narrow band of '" + phi->getName() +
        "' must be widened, which needs voxels of one size in all directions; resample it, or make it dense");
  const double layers =
      std::ceil(std::max(widen ? (wanted - phi->background()) / voxel : 0.0,
                         deepen && std::isfinite(interiorWidth) ? (wantedInside - known) / voxel : 0.0));
  // Not even a ball with a band of so many voxels would fit into a memory.
  constexpr double kMostLayers = 8192;
  if (!(layers <= kMostLayers))
    throw DataError("the narrow band of '" + phi->getName() + "' would have to be " + std::to_string(layers) +
                    " voxels wider; that is too much for voxels so small beside the whole");
  // A little more rather than less.
  constexpr int kSide = Leaf::DIM;
  return BandGrowth{.leaves = (static_cast<int>(layers) + kSide - 1) / kSide,
                    .wholeInside = deepen && !std::isfinite(interiorWidth)};
}

void growBand(Target& target, const BandGrowth& growth, Monitor& monitor) {
  const FloatGrid::Ptr phi = target.phi;
  monitor.begin("widening the band", 0);
  // Distances about one surface need no second round of the eight directions.
  constexpr int kSweeps = 1;
  target.phi = extendSdf(*phi, *sweepingMask(*phi, growth), kSweeps);
  // Sweeping touches the outermost of the values that it starts from; what was read stays what it was.
  auto accessor = target.phi->getAccessor();
  for (auto value = phi->cbeginValueOn(); value; ++value) accessor.setValue(value.getCoord(), *value);
  monitor.throwIfCancelled();
}

void extendBand(Target& target, double exteriorWidth, double interiorWidth, Monitor& monitor) {
  if (const std::optional<BandGrowth> growth = bandGrowth(target, exteriorWidth, interiorWidth, monitor))
    growBand(target, *growth, monitor);
}

double exteriorReach(const ExponentGridOptions& options) {
  const double least = options.alpha.range().first;
  if (!(least > 0))
    throw std::invalid_argument("alpha is " + shortText(least) + " somewhere; it must be above 0 everywhere");
  return std::max(0.0, elementary::log(options.orbit.escapeRadius) / least + options.beta.range().second);
}

double interiorReach(const ExponentGridOptions& options, double depth) {
  return std::max(0.0, depth / options.alpha.range().first - options.beta.range().first);
}

DetailReach detailReach(const ExponentGridOptions& options) {
  const double tau = options.detail->greatestThickness * options.mask.range().second;
  return {tau * options.detail->outward.range().second, tau * options.detail->detail.range().second};
}

namespace {

/// Where a point of the world is in the field.
enum class Place { Inside, Known, Outside, PastTheFaces };

Place placeOf(const Target& target, const Vec3d& point) {
  const Vec3d at = target.phi->worldToIndex(point);
  // Past the faces of a dense field the nearest face's value holds; that is no farther from the origin than the point
  // itself only where the box holds the origin.
  if (target.denseBox &&
      !openvdb::BBoxd(target.denseBox->min().asVec3d(), target.denseBox->max().asVec3d()).isInside(at))
    return Place::PastTheFaces;
  const Coord node = Coord::round(at);
  if (target.phi->tree().isValueOn(node)) return Place::Known;
  return target.phi->tree().getValue(node) < 0 ? Place::Inside : Place::Outside;
}

/// m(r) about a point. @param solid, outside  bounds of E where the distances end, inside and outside
julia::RadialMaximum radialMaximumAbout(const Vec3d& origin, const Target& target, const Baker& baker, double solid,
                                        double outside) {
  const Place place = placeOf(target, origin);
  if (place == Place::PastTheFaces) return {.step = 1, .maximum = {}};
  return baker.radialMaximum(origin, place == Place::Outside ? outside : solid);
}

}  // namespace

ExponentGrid exponentGrid(const Target& target, const FractalSpace& space, const ExponentGridOptions& options,
                          Monitor& monitor) {
  ExponentGrid result;
  result.space = space;
  result.interpolation = options.interpolation;
  result.denseBox = target.denseBox;
  Baker baker(target, space, options, monitor);
  const ExponentLaw& law = baker.law();
  const double logEscape = elementary::log(options.orbit.escapeRadius);
  constexpr double kNowhere = -std::numeric_limits<double>::infinity();
  // Where the distances end inside, E is at least as low as at their end.
  const double solidPhi = target.denseBox ? kNowhere : solidBeginsAt(*target.phi, monitor);
  double solid = solidPhi == kNowhere ? kNowhere : law.greatestInside(solidPhi);
  julia::DetailLaw detail;
  if (options.detail) {
    const Vec3d& origin = options.detail->origin;
    float surface = 0;
    law.apply({&origin, 1}, {&surface, 1});
    detail = julia::wantedLaw(radialMaximumAbout(origin, target, baker, solid, logEscape), static_cast<double>(surface),
                              options.orbit.maxIterations, options.orbit.escapeRadius);
    result.scale = detail.scale;
    baker.stretch(detail);
    solid = detail.at(solid);
  }
  const double largestStep = baker.largestStep();
  const double difference = largestStep * stepsInReach(options.interpolation);
  const julia::RadialMaximum maximum = radialMaximumAbout(space.centre, target, baker, solid, logEscape + 1);
  result.shell = julia::shellInterval(maximum, options.orbit.maxIterations, options.orbit.escapeRadius);
  result.orbit = options.orbit;
  result.orbit.logTrap = result.shell.lower;
  // Of the nodes that are read with a solid one, one lies next to it; all must be trapped.
  if (options.detail && solidPhi != kNowhere) {
    // What is steep elsewhere does not matter here.
    const double near = (stepsInReach(options.interpolation) - 1) * vdbtools::largestStep(target.phi->tree(), monitor);
    result.tooShallow = detail.at(law.greatestInside(solidPhi + near)) > result.shell.lower;
  } else {
    result.tooShallow = solid + difference > result.shell.lower + largestStep;
  }
  std::tie(result.alphaRange, result.betaRange) = law.ranges(result.scale);
  result.grid = baker.narrowed(result.shell, difference);
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
  return makeLatticeField<Real>(*exponent.grid, nodes, exponent.space, exponent.interpolation);
}

template std::shared_ptr<const julia::ScalarField<float>> makeExponentField(const ExponentGrid&);
template std::shared_ptr<const julia::ScalarField<double>> makeExponentField(const ExponentGrid&);

}  // namespace vdbtools
