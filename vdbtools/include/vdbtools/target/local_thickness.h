// SPDX-License-Identifier: Apache-2.0
/// @file local_thickness.h
/// The local thickness tau of a shape: at a point inside, the radius of the largest ball that fits in the shape and
/// holds the point [HR97]. A leg has its own thickness, and the body has its own.
///
/// What is returned is extended outside the shape, and nowhere steeper than kThicknessSlope, so that what is derived
/// from it varies gently: near a thin part, a thick one counts as thinner.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

namespace vdbtools {

/// World units of thickness by world units of length. Where a handle of radius r meets a thick part, the depth on its
/// axis grows like the hypotenuse of r and the distance into that part; with slopes up to sqrt(1 / D^2 - 1) a share D
/// of tau leaves the core connected there. This one serves up to D = 0.89.
inline constexpr double kThicknessSlope = 0.5;
/// tau is nowhere below this many voxels of the lattice on which it was found.
inline constexpr double kLeastThickness = 0.75;

struct LocalThickness {
  openvdb::FloatGrid::Ptr tau;     ///< world units, above 0; every node of a box about the shape is active
  double least = 0, greatest = 0;  ///< of tau over the nodes inside the shape, world units
  double leastAnywhere = 0;        ///< of tau over the whole box, world units; the greatest is the inside's
};

/// A part that is thinner than a voxel, so that it holds no node, counts as kLeastThickness voxels thick.
/// @param phi  world units, negative inside; the distances must be known over the whole inside and two voxels beyond
/// @throw DataError    phi is nowhere negative
/// @throw Interrupted
LocalThickness localThickness(const openvdb::FloatGrid& phi, Monitor& monitor);

}  // namespace vdbtools
