// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/distance/target.h"

#include "base/grid_memory.h"
#include "base/lattice_transform.h"
#include "base/openvdb/fast_sweeping.h"
#include "distance/band_growth.h"
#include "distance/cell_corners.h"
#include "distance/leaves.h"
#include "distance/volume_levels.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/Morphology.h>
#include <openvdb/tree/ValueAccessor.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;
using Accessor = openvdb::tree::ValueAccessor<const FloatTree>;

/// The largest value among the leaf's active nodes, and those next to them, that have an inactive negative face
/// neighbour; -inf if there is none.
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

/// Whether the leaf and its three neighbours on the positive sides contain only active nodes.
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

/// The leaves that hold nodes of the band and, if requested, of the whole inside, plus layers of leaves around them.
openvdb::MaskGrid::Ptr sweepingMask(const FloatGrid& phi, const BandGrowth& growth) {
  // One voxel per leaf.
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

}  // namespace

float solidBeginsAt(const FloatGrid& grid, Monitor& monitor) {
  const std::vector<const Leaf*> leaves = leavesOf(grid.tree());
  constexpr float kNever = -std::numeric_limits<float>::infinity();
  tbb::enumerable_thread_specific<float> begins(kNever);
  forEachLeaf(leaves.size(), monitor, [&](std::size_t i) {
    const Accessor accessor(grid.tree());
    float& most = begins.local();
    // A solid tile before the leaf is not visited by itself.
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

Target makeTarget(FloatGrid::Ptr phi, std::optional<openvdb::BBoxd> box) {
  if (phi->activeVoxelCount() == 0) throw DataError("the signed distance field '" + phi->getName() + "' is empty");
  valueRange(*phi);  // all are finite
  Target target;
  if (isDense(*phi)) {
    target.denseBox = phi->evalActiveVoxelBoundingBox();
  } else if (phi->background() == 0) {
    throw DataError("the signed distance field '" + phi->getName() +
                        "' is neither dense nor a narrow band: its background is 0 and must be positive, the outside",
                    Remedy::GiveIsovalue);
  } else if (box ? phi->background() < 0 : isNegativeOutside(*phi)) {
    throw DataError("the signed distance field '" + phi->getName() +
                        "' is negative outside its surface, and must be negative inside",
                    Remedy::TurnSign);
  }
  // A field without an inside is refused before its tiles take memory as voxels. Without tiles, insideBox() detects it
  // below.
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
  if (!hasCubicVoxels(*phi))
    throw DataError(
        "the narrow band of '" + phi->getName() +
        "' must be widened, which needs voxels of one size in all directions; resample it, or make it dense");
  const double layers =
      std::ceil(std::max(widen ? (wanted - phi->background()) / voxel : 0.0,
                         deepen && std::isfinite(interiorWidth) ? (wantedInside - known) / voxel : 0.0));
  // A band of this many voxels would not fit into memory even for a ball.
  constexpr double kMostLayers = 8192;
  if (!(layers <= kMostLayers))
    throw DataError("the narrow band of '" + phi->getName() + "' would have to be " + std::to_string(layers) +
                    " voxels wider; that is too much for voxels so small beside the whole");
  // Rounded up.
  constexpr int kSide = Leaf::DIM;
  return BandGrowth{.leaves = (static_cast<int>(layers) + kSide - 1) / kSide,
                    .wholeInside = deepen && !std::isfinite(interiorWidth)};
}

void growBand(Target& target, const BandGrowth& growth, Monitor& monitor) {
  const FloatGrid::Ptr phi = target.phi;
  monitor.begin(PhaseKind::WideningTheBand, 0);
  // For distances to one surface, one round of the eight directions suffices.
  constexpr int kSweeps = 1;
  target.phi = extendSdf(*phi, *sweepingMask(*phi, growth), kSweeps);
  // Sweeping changes the outermost of its initial values; the original values are restored.
  auto accessor = target.phi->getAccessor();
  for (auto value = phi->cbeginValueOn(); value; ++value) accessor.setValue(value.getCoord(), *value);
  monitor.throwIfCancelled();
}

void extendBand(Target& target, double exteriorWidth, double interiorWidth, Monitor& monitor) {
  if (const std::optional<BandGrowth> growth = bandGrowth(target, exteriorWidth, interiorWidth, monitor))
    growBand(target, *growth, monitor);
}

namespace {

using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::Vec3d;

/// Whether the sides of the voxels are parallel to the axes of the world.
bool isAligned(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return false;
  for (const Vec3d& unit : {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)}) {
    const Vec3d side = transform.baseMap()->applyJacobian(unit);
    const double longest = std::max({std::abs(side[0]), std::abs(side[1]), std::abs(side[2])});
    constexpr double kRounding = 1e-9;
    if (std::abs(side[0]) + std::abs(side[1]) + std::abs(side[2]) > (1 + kRounding) * longest) return false;
  }
  return true;
}

}  // namespace

openvdb::CoordBBox insideNodeBox(const openvdb::FloatGrid& phi) {
  openvdb::CoordBBox box;
  for (auto value = phi.tree().cbeginValueAll(); value; ++value)
    if (*value < 0) box.expand(value.getBoundingBox());
  if (box.empty()) throw DataError("the signed distance field is nowhere negative: it has no inside");
  return box;
}

BBoxd insideBox(const openvdb::FloatGrid& phi) {
  const openvdb::CoordBBox nodes = insideNodeBox(phi);
  const bool aligned = isAligned(phi.transform());
  BBoxd box, inIndexSpace(nodes.min().asVec3d(), nodes.max().asVec3d());
  const auto accessor = phi.getConstAccessor();
  // Where phi crosses 0 beyond an inside node. If the voxels are aligned, only the outermost nodes matter.
  for (auto value = phi.tree().cbeginValueAll(); value; ++value) {
    if (!(*value < 0)) continue;
    const openvdb::CoordBBox place = value.getBoundingBox();
    if (place.volume() > 1) {  // a tile, deep inside
      if (!aligned) box.expand(phi.transform().indexToWorld(BBoxd(place.min().asVec3d(), place.max().asVec3d())));
      continue;
    }
    const Coord node = place.min();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        if (aligned && node[axis] != (step < 0 ? nodes.min() : nodes.max())[axis]) continue;
        Coord next = node;
        next[axis] += step;
        const double inside = *value, outside = accessor.getValue(next);
        if (outside < 0) continue;
        Vec3d crossing = node.asVec3d();
        crossing[axis] += step * inside / (inside - outside);
        if (aligned)
          inIndexSpace.expand(crossing);
        else
          box.expand(phi.indexToWorld(crossing));
      }
    }
  }
  return aligned ? phi.transform().indexToWorld(inIndexSpace) : box;
}

bool centreIsInside(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box) {
  return openvdb::tools::BoxSampler::sample(phi.getConstAccessor(), phi.worldToIndex(box.getCenter())) < 0;
}

FractalSpace fitFractalSpace(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box) {
  FractalSpace space;
  space.scale = box.extents()[static_cast<int>(openvdb::math::MaxIndex(box.extents()))];
  if (!(space.scale > 0 && std::isfinite(space.scale)))
    throw std::invalid_argument("the target's longest side is " + shortText(space.scale) + "; it must be above 0");
  space.centre = box.getCenter();
  if (!centreIsInside(phi, box)) {
    float deepest = 0;
    Coord deepestNode;
    for (auto value = phi.tree().cbeginValueAll(); value; ++value) {
      if (!(*value < deepest)) continue;
      deepest = *value;
      deepestNode = Coord::round(value.getBoundingBox().getCenter());
    }
    if (deepest == 0) throw DataError("the signed distance field is nowhere negative: it has no inside");
    space.centre = phi.indexToWorld(deepestNode);
  }
  return space;
}

}  // namespace vdbtools
