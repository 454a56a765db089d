// SPDX-License-Identifier: Apache-2.0
/// @file fractal_space.h
/// Fractal space (DESIGN.md 2.0): the similarity in which the maps are iterated. The target's longest side is 1 there
/// and its centre 0, so that a setting means the same for a target of any size at any place.
#pragma once

#include "julia/embedding.h"
#include "vdbtools/base/grids.h"

namespace vdbtools {

struct FractalSpace {
  openvdb::Vec3d centre{0, 0, 0};  ///< world position of the dynamics' origin
  double scale = 1;                ///< world units a unit of fractal space, > 0

  julia::Point toFractal(const openvdb::Vec3d& world) const {
    return {toFractal(world[0], 0), toFractal(world[1], 1), toFractal(world[2], 2)};
  }
  /// One coordinate.
  double toFractal(double world, int axis) const { return (world - centre[axis]) / scale; }
  openvdb::Vec3d toWorld(const julia::Point& x) const {
    return {x[0] * scale + centre[0], x[1] * scale + centre[1], x[2] * scale + centre[2]};
  }
};

/// The box of phi < 0, world units, its faces where phi crosses 0 between nodes (linearly).
/// @throw DataError if phi is nowhere negative
openvdb::BBoxd insideBox(const openvdb::FloatGrid& phi);

/// Whether phi < 0 at the middle of the box: fitFractalSpace() then needs no distances deep inside.
bool centreIsInside(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

/// The space of a target: its centre is the box's if phi < 0 there, else the deepest node (the first in the order of
/// the tree). The origin is then moved by @a origin, in units of the space.
/// @throw DataError if phi is nowhere negative; std::invalid_argument if the box has no extent
FractalSpace fitFractalSpace(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box, const openvdb::Vec3d& origin);

}  // namespace vdbtools
