// SPDX-License-Identifier: Apache-2.0
/// @file lattice_field.h
/// Grids in the form that the dynamics reads.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"

#include "julia/bricks.h"
#include "julia/scalar_field.h"

#include <memory>

namespace vdbtools {

/// A grid's values at points of fractal space; points outside @a nodes (index space) get the value of the nearest node.
/// Copies the grid. @param knee  julia/bricks.h
template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeLatticeField(const openvdb::FloatGrid& grid,
                                                                 const openvdb::CoordBBox& nodes,
                                                                 const FractalSpace& space,
                                                                 julia::Interpolation interpolation,
                                                                 const julia::Knee& knee = {});

}  // namespace vdbtools
