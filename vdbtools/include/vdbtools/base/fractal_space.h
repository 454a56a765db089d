// SPDX-License-Identifier: Apache-2.0
/// @file fractal_space.h
/// Fractal space: the coordinates in which the maps are iterated, related to world space by a similarity. The target's
/// longest side is 1 there and its centre 0, so that a setting means the same for a target of any size at any place.
/// See target.h for the space of a target.
#pragma once

#include "julia/embedding.h"

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <algorithm>

namespace vdbtools {

struct FractalSpace {
  openvdb::Vec3d centre{0, 0, 0};  ///< world position of the dynamics' origin
  double scale = 1;                ///< world units per unit of fractal space, > 0

  julia::Point toFractal(const openvdb::Vec3d& world) const {
    return {toFractal(world[0], 0), toFractal(world[1], 1), toFractal(world[2], 2)};
  }
  /// Transforms one coordinate.
  double toFractal(double world, int axis) const { return (world - centre[axis]) / scale; }
  openvdb::Vec3d toWorld(const julia::Point& x) const {
    return {x[0] * scale + centre[0], x[1] * scale + centre[1], x[2] * scale + centre[2]};
  }
};

inline double longestSide(const openvdb::BBoxd& box) {
  const openvdb::Vec3d extents = box.extents();
  return std::max({extents[0], extents[1], extents[2]});
}

}  // namespace vdbtools
