// SPDX-License-Identifier: Apache-2.0
/// @file octave_grid.h
/// The local frequency of a texture of waves (julia/wave_versor.h): the thinner the target, the finer the texture.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/control/control.h"
#include "vdbtools/exponent/local_thickness.h"

namespace vdbtools {

/// The octave o at the nodes of the thickness' lattice. With it a wave of one cycle per unit makes F cycles across the
/// local thickness 2 tau, so 2^o = F / (2 tau) with tau in fractal space.
struct OctaveGrid {
  openvdb::FloatGrid::Ptr grid;
  FractalSpace space;
};

/// @param frequency  F, above 0
/// @throw std::invalid_argument  a frequency that is not above 0 and finite
OctaveGrid octaveGrid(const LocalThickness& thickness, const Control& frequency, const FractalSpace& space);

}  // namespace vdbtools
