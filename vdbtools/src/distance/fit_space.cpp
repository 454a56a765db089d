// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/distance/target.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
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
