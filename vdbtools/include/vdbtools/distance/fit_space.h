// SPDX-License-Identifier: Apache-2.0
/// @file fit_space.h
/// The fractal space (fractal_space.h) of a target, from its signed distances: phi < 0 inside, world units.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"

namespace vdbtools {

/// The box of the nodes where phi < 0, index space, tiles included.
/// @throw DataError if phi is nowhere negative
openvdb::CoordBBox insideNodeBox(const openvdb::FloatGrid& phi);

/// The box of phi < 0, world units, its faces where phi crosses 0 between nodes (linearly).
/// @throw DataError if phi is nowhere negative
openvdb::BBoxd insideBox(const openvdb::FloatGrid& phi);

/// Whether phi < 0 at the middle of the box: fitFractalSpace() then needs no distances deep inside.
bool centreIsInside(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

/// The space of a target: its centre is the box's if phi < 0 there, else the deepest node (the first in the order of
/// the tree). What is fitted to a target has this space.
/// @throw DataError if phi is nowhere negative; std::invalid_argument if the box has no extent
FractalSpace fitFractalSpace(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

}  // namespace vdbtools
