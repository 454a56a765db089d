// SPDX-License-Identifier: Apache-2.0
#include "render/shadow_proxy.h"

#include "vdbtools/field/fractal_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbtools {

using openvdb::BBoxd;
using openvdb::Vec3d;

namespace {

/// The ratio of the sizes of successive cubes.
constexpr double kGrowth = 4;

/// Only signs are used: F is not a distance, and some of its values are only bounds.
openvdb::FloatGrid::Ptr signsIn(const julia::FieldEvaluator& evaluator, const BBoxd& box, double voxel,
                                Monitor& monitor) {
  const FractalField made = fractalFieldEverywhere({evaluator, {}}, {.voxelSize = voxel, .box = box}, monitor);
  for (auto value = made.field->beginValueAll(); value; ++value) value.setValue(*value < 0 ? -1.0F : 1.0F);
  made.field->tree().root().setBackground(1, false);
  return made.field;
}

/// The distance that a ray from inside a box travels before it leaves it.
double wayOut(const BBoxd& box, const Vec3d& origin, const Vec3d& direction) {
  double out = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const double face = direction[axis] > 0 ? box.max()[axis] : box.min()[axis];
    out = std::min(out, (face - origin[axis]) / direction[axis]);
  }
  return std::max(out, 0.0);
}

}  // namespace

ShadowProxy::Level::Level(const julia::FieldEvaluator& evaluator, const BBoxd& where, int cellsAlong, Monitor& monitor)
    : box(where),
      voxel(where.extents()[static_cast<int>(openvdb::math::MaxIndex(where.extents()))] / cellsAlong),
      field(signsIn(evaluator, where, voxel, monitor)),
      cells(surfaceCells(field->tree(), monitor)) {
  if (!cells.empty()) lattice.emplace(field->tree(), cells);
}

ShadowProxy::ShadowProxy(const julia::FieldEvaluator& evaluator, const Need& need, Monitor& monitor) : mNeed(need) {
  const Vec3d sides = need.region.extents();
  const double longest = sides[static_cast<int>(openvdb::math::MaxIndex(sides))];
  for (double half = need.reach; kGrowth * half < longest; half *= kGrowth) {
    BBoxd cube(need.focus - Vec3d(half), need.focus + Vec3d(half));
    for (int axis = 0; axis < 3; ++axis) {
      cube.min()[axis] = std::max(cube.min()[axis], need.region.min()[axis]);
      cube.max()[axis] = std::min(cube.max()[axis], need.region.max()[axis]);
    }
    const Vec3d kept = cube.extents();
    if (std::min({kept[0], kept[1], kept[2]}) > half / need.cells)
      mLevels.emplace_back(evaluator, cube, need.cells, monitor);
  }
  mLevels.emplace_back(evaluator, need.region, need.cells, monitor);
  const Level& whole = mLevels.back();
  mMiddle = need.region.getCenter();
  mRadius = 0.5 * sides.length();
  if (whole.cells.empty()) return;
  const SurfaceBounds bounds = boundsOf(whole.cells);
  mMiddle = whole.voxel * bounds.centre;
  mRadius = whole.voxel * bounds.radius;
}

double ShadowProxy::lowestAlong(const Vec3d& direction) const {
  return mLevels.back().voxel * lowestCorner(direction, mLevels.back().cells);
}

std::size_t ShadowProxy::levelAt(const Vec3d& at) const {
  std::size_t level = 0;
  while (level + 1 < mLevels.size() && !mLevels[level].box.isInside(at)) ++level;
  return level;
}

ShadowProxy::Surface::Surface(const ShadowProxy& proxy) : mProxy(proxy) {
  for (const Level& level : proxy.mLevels) {
    mTracers.emplace_back();
    if (level.lattice) mTracers.back().emplace(*level.lattice);
  }
}

Vec3d ShadowProxy::Surface::leave(const Vec3d& at, const Vec3d& view, const Vec3d& normal) const {
  // The lattice's surface is up to a cell's diagonal from the true one. There is nothing between the point and the eye.
  constexpr double kAlongNormal = 0.75, kTowardsEye = 0.75;
  return at + mProxy.mLevels[mProxy.levelAt(at)].voxel * (kAlongNormal * normal - kTowardsEye * view);
}

bool ShadowProxy::Surface::blocked(const Vec3d& origin, const Vec3d& direction) {
  Vec3d at = origin;
  for (std::size_t i = mProxy.levelAt(at); i < mTracers.size(); ++i) {
    const Level& level = mProxy.mLevels[i];
    if (mTracers[i] && mTracers[i]->blocked(at / level.voxel, direction)) return true;
    if (i + 1 < mTracers.size()) at += wayOut(level.box, at, direction) * direction;
  }
  return false;
}

}  // namespace vdbtools
