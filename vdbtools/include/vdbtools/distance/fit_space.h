// SPDX-License-Identifier: Apache-2.0
/// @file fit_space.h
/// The fractal space (fractal_space.h) of a target, from its signed distances: phi < 0 inside, world units.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"

namespace vdbtools {

/// The bounding box of the nodes where phi < 0, in index space, including tiles.
/// @throw DataError if phi is nowhere negative
openvdb::CoordBBox insideNodeBox(const openvdb::FloatGrid& phi);

/// The bounding box of phi < 0 in world units. Its faces lie where phi, interpolated linearly between nodes, crosses 0.
/// @throw DataError if phi is nowhere negative
openvdb::BBoxd insideBox(const openvdb::FloatGrid& phi);

/// Whether phi < 0 at the centre of the box. If so, fitFractalSpace() needs no distances deep inside.
bool centreIsInside(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

/// The space of a target. Its centre is the centre of the box if phi < 0 there, else the deepest node (the first in the
/// order of the tree). Fits to a target use this space.
/// @throw DataError if phi is nowhere negative; std::invalid_argument if the box has no extent
FractalSpace fitFractalSpace(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

}  // namespace vdbtools
