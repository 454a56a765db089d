// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/distance/fit_space.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/number_text.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Coord;

}  // namespace

openvdb::CoordBBox insideNodeBox(const openvdb::FloatGrid& phi) {
  openvdb::CoordBBox box;
  for (auto value = phi.tree().cbeginValueAll(); value; ++value)
    if (*value < 0) box.expand(value.getBoundingBox());
  if (box.empty()) throw DataError("the signed distance field is nowhere negative: it has no inside");
  return box;
}

openvdb::BBoxd insideBox(const openvdb::FloatGrid& phi) {
  const openvdb::CoordBBox nodes = insideNodeBox(phi);
  openvdb::Vec3d low = nodes.min().asVec3d(), high = nodes.max().asVec3d();
  const auto accessor = phi.getConstAccessor();
  // Only for outermost inside nodes: find how far beyond them phi crosses 0.
  for (auto value = phi.tree().cbeginValueAll(); value; ++value) {
    if (!(*value < 0)) continue;
    const openvdb::CoordBBox box = value.getBoundingBox();
    if (box.volume() > 1) continue;  // a tile lies deep inside; its extent has been counted already
    const Coord node = box.min();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        if (node[axis] != (step < 0 ? nodes.min() : nodes.max())[axis]) continue;
        Coord next = node;
        next[axis] += step;
        const double inside = *value, outside = accessor.getValue(next);
        const double crossing = node[axis] + step * inside / (inside - outside);
        if (step < 0)
          low[axis] = std::min(low[axis], crossing);
        else
          high[axis] = std::max(high[axis], crossing);
      }
    }
  }
  return phi.transform().indexToWorld(openvdb::BBoxd(low, high));
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
