// SPDX-License-Identifier: Apache-2.0
/// @file local_thickness.h
/// The local thickness tau of a shape: at a point inside, the radius of the largest ball that fits in the shape and
/// holds the point [HR97]. A leg has its own thickness, and the body has its own.
///
/// What is returned is extended outside the shape, and nowhere steeper than a given slope, so that what is derived
/// from it varies gently: near a thin part, a thick one counts as thinner.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <memory>

namespace vdbtools {

/// World units of thickness by world units of length: along the faces of a convex body tau grows from its edges about
/// as fast by itself.
inline constexpr double kThicknessSlope = 1;

/// The slope for a depth of detail of the share @a detail of tau: that for which the depth itself, detail times tau,
/// has no slope above 0.16, and never above kThicknessSlope. More detail is then nowhere less deep. And up to a share
/// of 0.8 a thin part stays joined to a thick one: at the mouth of a handle of radius r, tau begins to rise at a
/// distance of r in front of it, but the depth of the shape only behind it; so detail (1 + slope) must be below 1.
double thicknessSlope(double detail);

/// tau is nowhere below this many voxels of the lattice on which it was found.
inline constexpr double kLeastThickness = 0.75;

struct LocalThickness {
  openvdb::FloatGrid::Ptr tau;     ///< world units, above 0; every node of a box about the shape is active
  double least = 0, greatest = 0;  ///< of tau over the nodes inside the shape, world units
  double leastAnywhere = 0;        ///< of tau over the whole box, world units; the greatest is the inside's
};

/// A part that is thinner than a voxel, so that it holds no node, counts as kLeastThickness voxels thick.
/// @param phi  world units, negative inside; the distances must be known over the whole inside and two voxels beyond
/// @param slope  world units of thickness by world units of length, > 0
/// @throw DataError    phi is nowhere negative
/// @throw Interrupted
LocalThickness localThickness(const openvdb::FloatGrid& phi, Monitor& monitor, double slope = kThicknessSlope);

/// The same for one slope after another: what does not depend on the slope, which is most of the work, is done once.
class ThicknessFinder {
 public:
  /// @param phi  as above
  /// @throw DataError, Interrupted
  ThicknessFinder(const openvdb::FloatGrid& phi, Monitor& monitor);

  /// @throw Interrupted
  LocalThickness limitedTo(double slope, Monitor& monitor) const;

 private:
  struct Found;
  std::shared_ptr<const Found> mFound;
};

}  // namespace vdbtools
