// SPDX-License-Identifier: Apache-2.0
#include "distance/wide_distance.h"

#include "base/lattice_transform.h"
#include "base/openvdb/fast_sweeping.h"
#include "distance/known_distance.h"
#include "vdbtools/base/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;

constexpr int kGain = 8;  ///< voxels that each level adds to its band; more are more accurate, and slower

/// Whether the level has every node that is needed to read any point of the box. Returns false also for boxes of many
/// voxels, which a coarser level covers.
bool knowsAll(const FloatGrid& level, const BBoxd& box) {
  constexpr double kMost = 64;  // voxels along an axis
  const BBoxd region = level.transform().worldToIndex(box);
  if (!((region.max() - region.min()).length() < kMost)) return false;
  const BandAccessor accessor(level.tree());
  const CoordBBox nodes(Coord::floor(region.min()), Coord::floor(region.max()).offsetBy(1));
  for (auto node = nodes.begin(); node; ++node)
    if (!accessor.isValueOn(*node)) return false;
  return true;
}

}  // namespace

FloatGrid::Ptr coarserBand(const FloatGrid& fine, int gain) {
  const FloatGrid::Ptr kept = FloatGrid::create(2 * fine.background());
  kept->setTransform(coarserTransform(fine.transform()));
  kept->setGridClass(openvdb::GRID_LEVEL_SET);
  auto accessor = kept->getAccessor();
  for (auto value = fine.cbeginValueOn(); value; ++value) {
    const Coord node = value.getCoord();
    if (((node[0] | node[1] | node[2]) & 1) == 0) accessor.setValue(node >> 1, *value);
  }
  openvdb::tools::signedFloodFill(kept->tree());
  // Equivalent to OpenVDB's dilateSdf(), which cannot handle a field without nodes inside: thin parts lie between the
  // nodes.
  bool anyInside = false;
  for (auto value = kept->cbeginValueOn(); value; ++value) anyInside |= *value < 0;
  FloatGrid::Ptr wide = dilateSdf(*kept, gain, anyInside);
  // Sweeping changes the outermost of its initial values; the known values are restored.
  auto known = wide->getAccessor();
  for (auto value = kept->cbeginValueOn(); value; ++value) known.setValue(value.getCoord(), *value);
  return wide;
}

WideDistance::WideDistance(const Target& target, const BBoxd& box, Monitor& monitor)
    : mLevels{target.phi}, mDenseBox(target.denseBox) {
  if (mDenseBox) return;
  if (!hasCubicVoxels(*target.phi))
    throw DataError("distances far from the narrow band of '" + target.phi->getName() +
                    "' need voxels of one size in all directions; resample it, or make it dense");
  while (!knowsAll(*mLevels.back(), box)) {
    mLevels.push_back(coarserBand(*mLevels.back(), kGain));
    monitor.throwIfCancelled();
  }
}

void WideDistance::sample(std::span<const Vec3d> points, std::span<double> phi) const {
  std::vector<BandAccessor> levels;
  for (const FloatGrid::ConstPtr& level : mLevels) levels.emplace_back(level->tree());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (mDenseBox) {
      Vec3d index = mLevels.front()->worldToIndex(points[i]);
      for (int axis = 0; axis < 3; ++axis)
        index[axis] = std::clamp<double>(index[axis], mDenseBox->min()[axis], mDenseBox->max()[axis]);
      phi[i] = openvdb::tools::BoxSampler::sample(levels.front(), index);
      continue;
    }
    std::optional<double> found;
    for (std::size_t l = 0; l < levels.size() && !found; ++l)
      found = knownDistance(levels[l], mLevels[l]->worldToIndex(points[i]));
    phi[i] = found.value();
  }
}

}  // namespace vdbtools
