// SPDX-License-Identifier: Apache-2.0
/// @file control_grid.h
/// Controls in the form that the dynamics reads: values on a lattice, at points of fractal space.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/control/control.h"

#include "julia/scalar_field.h"

#include <map>
#include <memory>
#include <string>

namespace vdbtools {

struct ControlGrid {
  openvdb::FloatGrid::Ptr grid;  ///< every node of its box is active
  FractalSpace space{};          ///< its world space is the grid's
};

/// Grids by the names that a map gives them.
using ControlGrids = std::map<std::string, ControlGrid>;

/// Samples a control on the lattice of 100 nodes along the target's longest side (control.h). The grid lies in fractal
/// space itself, so its own space is the identity.
/// @param space  the space of the map
ControlGrid controlGrid(const Control& control, const ControlContext& context, const FractalSpace& space);

/// Reads the grid trilinearly; a point outside the lattice gets the value of the nearest point of the lattice.
template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeControlField(const ControlGrid& grid);

extern template std::shared_ptr<const julia::ScalarField<float>> makeControlField(const ControlGrid&);
extern template std::shared_ptr<const julia::ScalarField<double>> makeControlField(const ControlGrid&);

}  // namespace vdbtools
