// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/control/control.h"

#include "control/control_kinds.h"

#include "vdbtools/distance/target.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <utility>

namespace vdbtools {

double Control::at(const openvdb::Vec3d& point) const {
  double value = 0;
  sample({&point, 1}, {&value, 1});
  return value;
}

std::shared_ptr<const ControlSource> parseControl(const RecipeReader& reader, const std::string& option) {
  // Grids come last, because they accept any text that ends like the name of a VDB.
  constexpr ControlSourcePtr (*kParsers[])(const RecipeReader&, const std::string&) = {
      parseNumberControl, parseRampControl,       parsePaintControl, parseTextureControl,
      parseNearControl,   parseExpressionControl, parseGridControl};
  for (const auto& parser : kParsers)
    if (ControlSourcePtr source = parser(reader, option)) return source;
  reader.refuse(
      option,
      "a number, a ramp such as x:10:300:smooth, FILE.vdb[:GRID], paint:NAME:LOW:HIGH, texture:FILE:LOW:HIGH, "
      "near:FILE:DISTANCE:NEAR:FAR, or expr:TEXT");
}

namespace {

using openvdb::FloatGrid;
using openvdb::Vec3d;

class ClampedField final : public ControlField {
 public:
  ClampedField(FloatGrid::ConstPtr grid, const std::optional<openvdb::CoordBBox>& nodes)
      : mGrid(std::move(grid)), mNodes(nodes) {
    double low = mGrid->background(), high = low;
    for (auto value = mGrid->tree().cbeginValueAll(); value; ++value) {
      low = std::min<double>(low, *value);
      high = std::max<double>(high, *value);
    }
    mRange = {low, high};
  }

  void sample(std::span<const Vec3d> points, std::span<double> values) const override {
    const FloatGrid::ConstAccessor accessor = mGrid->getConstAccessor();
    for (std::size_t i = 0; i < points.size(); ++i) {
      Vec3d at = mGrid->worldToIndex(points[i]);
      for (int axis = 0; mNodes && axis < 3; ++axis)
        at[axis] = std::clamp<double>(at[axis], mNodes->min()[axis], mNodes->max()[axis]);
      // Rounding may take the interpolated value out of the range.
      values[i] = std::clamp<double>(openvdb::tools::BoxSampler::sample(accessor, at), mRange.first, mRange.second);
    }
  }
  std::pair<double, double> range() const override { return mRange; }

 private:
  FloatGrid::ConstPtr mGrid;
  std::optional<openvdb::CoordBBox> mNodes;
  std::pair<double, double> mRange;
};

}  // namespace

Control clampedControl(FloatGrid::ConstPtr grid, const std::optional<openvdb::CoordBBox>& nodes) {
  return Control(std::make_shared<ClampedField>(std::move(grid), nodes));
}

Control clampedControl(const FloatGrid::ConstPtr& grid) {
  return clampedControl(grid, grid->evalActiveVoxelBoundingBox());
}

Control distanceControl(const Target& target) { return clampedControl(target.phi, target.denseBox); }

}  // namespace vdbtools
