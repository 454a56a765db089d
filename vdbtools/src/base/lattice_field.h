// SPDX-License-Identifier: Apache-2.0
/// @file lattice_field.h
/// Grids as the dynamics reads them.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"

#include "julia/bricks.h"
#include "julia/scalar_field.h"

#include <memory>

namespace vdbtools {

/// A grid's values at points of fractal space; beyond @a nodes, index space, those of the nearest node. Copies the
/// grid.
template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeLatticeField(const openvdb::FloatGrid& grid,
                                                                 const openvdb::CoordBBox& nodes,
                                                                 const FractalSpace& space,
                                                                 julia::Interpolation interpolation);

}  // namespace vdbtools
