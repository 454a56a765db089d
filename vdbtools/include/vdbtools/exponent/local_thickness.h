// SPDX-License-Identifier: Apache-2.0
/// @file local_thickness.h
/// The local thickness tau of a shape: at a point inside, the radius of the largest ball that fits in the shape and
/// contains the point [HR97]. A leg has its own thickness, and so has the body.
///
/// The result is extended outside the shape, and its slope is limited to a given value, so that quantities derived from
/// it vary gently: near a thin part, a thick one counts as thinner.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/control/control.h"

#include <memory>
#include <optional>

namespace vdbtools {

/// World units of thickness per world unit of length. Along the faces of a convex body, tau itself grows from the edges
/// at about this rate.
inline constexpr double kThicknessSlope = 1;

/// The slope for a depth of detail of the fraction @a detail of tau. It limits the slope of the depth itself, detail
/// times tau, to 0.16, and never exceeds kThicknessSlope. Hence more detail is nowhere less deep. Up to a fraction of
/// 0.8 a thin part also stays joined to a thick one: at the mouth of a handle of radius r, tau begins to rise at a
/// distance of r in front of it, but the depth of the shape only behind it; so detail (1 + slope) must be below 1.
double thicknessSlope(double detail);

/// tau is nowhere below this many voxels of the lattice on which it was computed.
inline constexpr double kLeastThickness = 0.75;

struct LocalThickness {
  openvdb::FloatGrid::Ptr tau;     ///< world units, above 0; every node of a box around the shape is active
  double least = 0, greatest = 0;  ///< extremes of tau over the nodes inside the shape, world units
  double leastAnywhere = 0;        ///< minimum of tau over the whole box, world units; the maximum is `greatest`
};

/// Computes the local thickness. A part that is thinner than a voxel, so that it contains no node, counts as
/// kLeastThickness voxels thick.
/// @param phi  world units, negative inside; the distances must be known over the whole inside and two voxels beyond
/// @param slope  maximum slope, world units of thickness per world unit of length, > 0
/// @throw DataError    phi is nowhere negative
/// @throw Interrupted
LocalThickness localThickness(const openvdb::FloatGrid& phi, Monitor& monitor, double slope = kThicknessSlope);

/// Computes the local thickness for several slopes. Most of the work does not depend on the slope and is done once.
class ThicknessFinder {
 public:
  /// @param phi  as for localThickness()
  /// @throw DataError, Interrupted
  ThicknessFinder(const openvdb::FloatGrid& phi, Monitor& monitor);

  /// @throw Interrupted
  LocalThickness limitedTo(double slope, Monitor& monitor) const;

  /// The thickness, world units, below which only @a share (0 to 1) of the surface lies: twice the radius tau. The
  /// surroundings of a thick part count as thick up to twice its radius away, so that edges, at which tau falls to 0,
  /// are not taken for thin parts. nullopt if no node is within a voxel of the surface.
  /// @throw Interrupted
  std::optional<double> leastThickness(double share, Monitor& monitor) const;

 private:
  struct Found;
  std::shared_ptr<const Found> mFound;
};

// The local frequency of a texture of waves (julia/wave_versor.h): the thinner the target, the finer the texture.

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
