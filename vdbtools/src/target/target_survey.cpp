// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/target_survey.h"

#include "repair/solid_input.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/target/target_input.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;
using openvdb::Vec3d;

class ThicknessField final : public ControlField {
 public:
  explicit ThicknessField(const LocalThickness& thickness)
      : mTau(thickness.tau), mRange(thickness.leastAnywhere, thickness.greatest) {
    const openvdb::CoordBBox nodes = mTau->evalActiveVoxelBoundingBox();
    mLow = nodes.min().asVec3d();
    mHigh = nodes.max().asVec3d();
  }

  void sample(std::span<const Vec3d> points, std::span<double> values) const override {
    const FloatGrid::ConstAccessor accessor = mTau->getConstAccessor();
    for (std::size_t i = 0; i < points.size(); ++i) {
      Vec3d at = mTau->worldToIndex(points[i]);
      for (int axis = 0; axis < 3; ++axis) at[axis] = std::clamp(at[axis], mLow[axis], mHigh[axis]);
      // Rounding may take the interpolated value out of the range.
      values[i] = std::clamp<double>(openvdb::tools::BoxSampler::sample(accessor, at), mRange.first, mRange.second);
    }
  }
  std::pair<double, double> range() const override { return mRange; }

 private:
  FloatGrid::ConstPtr mTau;
  std::pair<double, double> mRange;
  Vec3d mLow, mHigh;  ///< index space
};

}  // namespace

LocalThickness TargetSurvey::thickness(Monitor& monitor, double slope) {
  const auto found = mThickness.find(slope);
  if (found != mThickness.end()) return found->second;
  constexpr std::size_t kMost = 8;  // slopes; a user who adjusts the depth of detail by hand tries hundreds
  if (!mFinder) mFinder.emplace(*mPhi, monitor);
  LocalThickness limited = mFinder->limitedTo(slope, monitor);
  if (mThickness.size() >= kMost) mThickness.clear();
  return mThickness.emplace(slope, std::move(limited)).first->second;
}

Control thicknessControl(const LocalThickness& thickness) {
  return Control(std::make_shared<ThicknessField>(thickness));
}

std::optional<SolidShape> shapeOfSolid(const Mesh& mesh, const MeshReport& report) {
  constexpr double kMargin = 4;  // voxels
  if (!(longestSide(report.box) > 0)) return std::nullopt;
  const Vec3d middle = report.box.getCenter();
  Monitor monitor;
  try {
    const MeshToSdfOptions band = sdfBand(surveyVoxel(report.box), kMargin, std::numeric_limits<double>::infinity());
    const FloatGrid::Ptr phi = makeSdfAbout(middle, mesh, band, MendOptions(), monitor).grid;
    const LocalThickness thickness = localThickness(*phi, monitor);
    return SolidShape{largestInscribedBall(*phi, middle, &mesh), thickness.least, thickness.greatest};
  } catch (const DataError&) {
    return std::nullopt;
  }
}

double insideVolume(const FloatGrid& phi) {
  const double voxel = phi.voxelSize()[0];
  // The fraction of a node's cell on the inside of a plane at this distance.
  const auto share = [voxel](double value) { return std::clamp(0.5 - value / voxel, 0.0, 1.0); };
  double nodes = 0;
  for (auto leaf = phi.tree().cbeginLeaf(); leaf; ++leaf) {
    // Separate sums, which do not depend on each other.
    double sums[FloatGrid::TreeType::LeafNodeType::DIM] = {};
    const float* const values = leaf->buffer().data();
    for (std::size_t i = 0; i < FloatGrid::TreeType::LeafNodeType::SIZE; i += std::size(sums))
      for (std::size_t k = 0; k < std::size(sums); ++k) sums[k] += share(static_cast<double>(values[i + k]));
    for (const double sum : sums) nodes += sum;
  }
  auto tile = phi.cbeginValueAll();
  tile.setMaxDepth(FloatGrid::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) nodes += share(static_cast<double>(*tile)) * static_cast<double>(tile.getVoxelCount());
  return nodes * phi.voxelSize().product();
}

double insideVolume(const FloatGrid& phi, const openvdb::BBoxd& box) {
  const double voxel = phi.voxelSize()[0];
  const openvdb::BBoxd within = phi.transform().worldToIndex(box);
  // The overlap of the cells around the nodes from low to high with the box along an axis, in voxels.
  const auto overlap = [&](int low, int high, int axis) {
    return std::max(0.0, std::min(high + 0.5, within.max()[axis]) - std::max(low - 0.5, within.min()[axis]));
  };
  double nodes = 0;
  for (auto value = phi.cbeginValueAll(); value; ++value) {
    const double share = std::clamp(0.5 - static_cast<double>(*value) / voxel, 0.0, 1.0);
    if (share == 0) continue;
    const openvdb::CoordBBox at = value.getBoundingBox();
    double cells = share;
    for (int axis = 0; axis < 3; ++axis) cells *= overlap(at.min()[axis], at.max()[axis], axis);
    nodes += cells;
  }
  return nodes * phi.voxelSize().product();
}

}  // namespace vdbtools
