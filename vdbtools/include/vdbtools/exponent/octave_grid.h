// SPDX-License-Identifier: Apache-2.0
/// @file octave_grid.h
/// How fine a texture of waves (julia/wave_versor.h) is at each place of a target: as much finer as the target is
/// thinner there.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/control/control.h"
#include "vdbtools/exponent/local_thickness.h"

namespace vdbtools {

/// The octave o at the nodes of the thickness' lattice: with it a wave of one turn a unit makes F turns across the
/// local thickness 2 tau, so that 2^o = F / (2 tau) with tau in fractal space.
struct OctaveGrid {
  openvdb::FloatGrid::Ptr grid;
  FractalSpace space;
};

/// @param frequency  F, above 0
/// @throw std::invalid_argument  a frequency that is not above 0 and finite
OctaveGrid octaveGrid(const LocalThickness& thickness, const Control& frequency, const FractalSpace& space);

}  // namespace vdbtools
