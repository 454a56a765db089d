// SPDX-License-Identifier: Apache-2.0
/// @file scene_grain.h
/// The grain of a texture over a scene's target.
#pragma once

#include "scene/placed_target.h"
#include "vdbtools/grain/grain.h"
#include "vdbtools/maps/grain_options.h"

#include <complex>
#include <vector>

namespace vdbtools {

/// The parts of the target that controls may refer to. @param needsTarget  whether one of them needs the distances
ControlContext controlContext(bool needsTarget, SharedTarget& shared, const PlacedSpace& placed, Monitor& monitor);

/// The directions of a grain on the target's surface, and how long the waves are there.
struct GrainDirections {
  GrainSurface surface;
  LocalThickness thickness;
  std::vector<std::complex<double>> directions;  ///< tangents of length 1, for each point of the surface
  std::vector<double> wavelength;                ///< of the lattice's waves, world units, likewise
  GrainScale scale{};
};

/// @param frequency  of the texture
/// @throw DataError  the target lacks what the grain asks for
GrainDirections grainDirectionsOf(const GrainSettings& settings, const ControlSetting& frequency, SharedTarget& shared,
                                  const PlacedTarget& target, Monitor& monitor);
/// The grids that a texture reads. @throw as above
GrainGrids grainOf(const GrainSettings& settings, const ControlSetting& frequency, SharedTarget& shared,
                   const PlacedTarget& target, Monitor& monitor);

}  // namespace vdbtools
