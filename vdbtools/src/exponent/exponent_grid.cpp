// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/exponent/exponent_grid.h"

#include "base/elementary.h"
#include "base/grid_sampler.h"
#include "base/lattice_field.h"
#include "distance/band_growth.h"
#include "distance/cell_corners.h"
#include "distance/leaves.h"
#include "exponent/exponent_law.h"
#include "exponent/radial_bound.h"
#include "vdbtools/base/text.h"

#include "julia/detail.h"

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

using Accessor = openvdb::tree::ValueAccessor<const FloatTree>;

// Bit z of a row along z, in a form that compilers vectorise.
constexpr unsigned kBit[Leaf::DIM] = {1, 2, 4, 8, 16, 32, 64, 128};

/// The largest |difference| between a leaf's nodes and their next face neighbours, if both are active.
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

/// An upper bound of the difference between active face neighbours.
double largestStep(const FloatTree& tree, Monitor& monitor) {
  const std::vector<const Leaf*> leaves = leavesOf(tree);
  tbb::enumerable_thread_specific<float> largest(0.0f);
  forEachLeaf(leaves.size(), monitor, [&](std::size_t i) {
    float& most = largest.local();
    most = std::max(most, largestStepOf(CellCorners(*leaves[i], Accessor(tree))));
  });
  constexpr double kRounding = 1 + 1e-6;
  return kRounding * *std::max_element(largest.begin(), largest.end());
}

/// The number of steps between face neighbours that separate two nodes used in one read: three for the corners of a
/// cell, and three times that for the wider support of the quadratic B-spline.
int stepsInReach(julia::Interpolation interpolation) {
  return interpolation == julia::Interpolation::Quadratic ? 9 : 3;
}

/// E on the nodes of phi, and its properties.
class Baker {
 public:
  Baker(const Target& target, const FractalSpace& space, const ExponentGridOptions& options, Monitor& monitor)
      : mLaw(options, space.scale, target.phi->voxelSize()[0]), mMonitor(monitor), mTransform(target.phi->transform()) {
    const std::vector<const Leaf*> leaves = leavesOf(target.phi->tree());
    mLeaves.resize(leaves.size());
    monitor.begin(PhaseKind::Exponent, 2 * leaves.size());
    try {
      forEachLeaf(leaves.size(), monitor, [&](std::size_t i) { mLeaves[i] = bake(*leaves[i]); });
    } catch (...) {
      for (Leaf* leaf : mLeaves) delete leaf;
      throw;
    }
    for (Leaf* leaf : mLeaves) mTree.addLeaf(leaf);
  }

  const FloatTree& tree() const { return mTree; }
  double largestStep() const { return vdbtools::largestStep(mTree, mMonitor); }
  const ExponentLaw& law() const { return mLaw; }

  /// Converts the position in the shell of detail to v.
  void stretch(const julia::DetailLaw& law) {
    forEachLeaf(mLeaves.size(), mMonitor, [&](std::size_t i) {
      for (auto value = mLeaves[i]->beginValueOn(); value; ++value)
        value.setValue(static_cast<float>(law.line(static_cast<double>(*value))));
    });
  }

  /// The grid, in which values farther outside the interval than any cell that touches it are replaced by a constant.
  FloatGrid::Ptr narrowed(const julia::ShellInterval& shell, double differenceInReach) {
    const float outside = static_cast<float>(shell.upper + 1);
    const bool hasLower = std::isfinite(shell.lower);
    const float inside = hasLower ? static_cast<float>(shell.lower - 1) : -1.0f;
    const double highest = shell.upper + differenceInReach,
                 lowest = hasLower ? shell.lower - differenceInReach : -std::numeric_limits<double>::infinity();
    std::vector<std::uint8_t> keeps(mLeaves.size());
    forEachLeaf(mLeaves.size(), mMonitor, [&](std::size_t i) {
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
  /// Applies the law to phi. Inactive nodes keep a value with phi's sign.
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

  ExponentLaw mLaw;
  Monitor& mMonitor;
  const openvdb::math::Transform& mTransform;
  FloatTree mTree{1.0f};
  std::vector<Leaf*> mLeaves;  // the leaves of mTree
};

}  // namespace

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

/// The position of a world point relative to the field.
enum class Place { Inside, Known, Outside, PastTheFaces };

Place placeOf(const Target& target, const Vec3d& point) {
  const Vec3d at = target.phi->worldToIndex(point);
  // Beyond the faces of a dense field the nearest face's value applies. That point is guaranteed to be no farther from
  // the origin than the point itself only if the box contains the origin.
  if (target.denseBox &&
      !openvdb::BBoxd(target.denseBox->min().asVec3d(), target.denseBox->max().asVec3d()).isInside(at))
    return Place::PastTheFaces;
  const Coord node = Coord::round(at);
  if (target.phi->tree().isValueOn(node)) return Place::Known;
  return target.phi->tree().getValue(node) < 0 ? Place::Inside : Place::Outside;
}

/// What is known of the values of a baker: E, or w of julia/detail.h.
struct BakedBounds {
  double solid;    ///< where the distances end inside
  double outside;  ///< where they end outside
  double spread;   ///< as in RadialBound
};

/// m(r) of shell.h about a point.
julia::RadialMaximum boundsAbout(const Vec3d& point, const Target& target, const Baker& baker,
                                 const FractalSpace& space, julia::Interpolation interpolation,
                                 const BakedBounds& bounds, Monitor& monitor) {
  const Place place = placeOf(target, point);
  if (place == Place::PastTheFaces) return {.step = 1, .maximum = {}};
  return RadialBound(baker.tree(), target.phi->transform(), point, space.scale, interpolation, bounds.solid,
                     bounds.spread, monitor)
      .maximum(place == Place::Outside ? bounds.outside : bounds.solid, monitor);
}

/// The v from which E is made.
double beforeKnee(double exponent, const julia::Knee& knee) {
  return exponent < knee.at ? knee.at + (exponent - knee.at) / (1 + knee.more) : exponent;
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
  // Beyond the end of the distances inside, E is at most its value at that end.
  const double solidPhi = target.denseBox ? kNowhere : solidBeginsAt(*target.phi, monitor);
  double solid = solidPhi == kNowhere ? kNowhere : law.greatestInside(solidPhi);
  double largestStep = baker.largestStep();
  const BakedBounds bounds{
      .solid = solid,
      .outside = options.detail ? 1 : logEscape + 1,
      .spread = largestStep * stepsInReach(options.interpolation),
  };
  const auto about = [&](const Vec3d& point) {
    return boundsAbout(point, target, baker, space, options.interpolation, bounds, monitor);
  };
  julia::RadialMaximum maximum = about(space.centre);
  julia::DetailLaw detail;
  if (options.detail) {
    const Vec3d& origin = options.detail->origin;
    float surface = 0;
    law.apply({&origin, 1}, {&surface, 1});
    detail = julia::wantedLaw(origin == space.centre ? maximum : about(origin), static_cast<double>(surface),
                              options.orbit.maxIterations, options.orbit.escapeRadius);
    result.scale = detail.scale;
    result.knee = detail.knee();
    baker.stretch(detail);
    solid = detail.at(solid);
    // v is rounded where it is stored.
    constexpr double kRounding = 1e-6;
    largestStep = detail.scale * largestStep + kRounding * (logEscape + detail.scale);
    for (double& bound : maximum.maximum) bound = detail.at(bound + kRounding * logEscape / detail.scale);
  }
  const double difference = largestStep * stepsInReach(options.interpolation);
  result.shell = julia::shellInterval(maximum, options.orbit.maxIterations, options.orbit.escapeRadius);
  result.shellOfNodes = {beforeKnee(result.shell.lower, result.knee), beforeKnee(result.shell.upper, result.knee)};
  result.orbit = options.orbit;
  result.orbit.logTrap = result.shell.lower;
  // Among the nodes that are read together with a solid one, one is adjacent to it; all of them must be trapped.
  if (options.detail && solidPhi != kNowhere) {
    // Steep places elsewhere do not matter here.
    const double near = (stepsInReach(options.interpolation) - 1) * vdbtools::largestStep(target.phi->tree(), monitor);
    result.tooShallow = detail.at(law.greatestInside(solidPhi + near)) > result.shell.lower;
  } else {
    result.tooShallow = solid + difference > result.shell.lower + largestStep;
  }
  std::tie(result.alphaRange, result.betaRange) = law.ranges(result.scale);
  result.grid = baker.narrowed(result.shellOfNodes, difference);
  return result;
}

template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeExponentField(const ExponentGrid& exponent) {
  CoordBBox nodes = exponent.grid->evalActiveVoxelBoundingBox();
  if (nodes.empty()) nodes = CoordBBox(Coord(0), Coord(0));
  // One value surrounds a narrow band; with a rim of it, the nearest node is correct everywhere beyond.
  constexpr int kRim = 2;
  if (exponent.denseBox)
    nodes = *exponent.denseBox;
  else
    nodes.expand(kRim);
  return makeLatticeField<Real>(*exponent.grid, nodes, exponent.space, exponent.interpolation, exponent.knee);
}

template std::shared_ptr<const julia::ScalarField<float>> makeExponentField(const ExponentGrid&);
template std::shared_ptr<const julia::ScalarField<double>> makeExponentField(const ExponentGrid&);

}  // namespace vdbtools
