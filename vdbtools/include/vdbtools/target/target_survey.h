// SPDX-License-Identifier: Apache-2.0
/// @file target_survey.h
/// What a target is like as a whole: where it is deepest, how thick it is at each place, how much it holds. These are
/// found from distances over its whole inside on a coarse lattice, which costs little beside the fine distances near
/// the surface.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/control/control.h"
#include "vdbtools/exponent/local_thickness.h"
#include "vdbtools/target/inscribed_ball.h"

#include <map>
#include <optional>

namespace vdbtools {

class TargetSurvey {
 public:
  /// @param phi  world units, negative inside, known over the whole inside and a few voxels outside
  explicit TargetSurvey(openvdb::FloatGrid::ConstPtr phi) : mPhi(std::move(phi)) {}

  const openvdb::FloatGrid::ConstPtr& phi() const { return mPhi; }

  /// The local thickness for a slope, found when it is first asked for, and remembered until a few other slopes were
  /// asked for.
  /// @throw DataError, Interrupted  as localThickness()
  LocalThickness thickness(Monitor& monitor, double slope = kThicknessSlope);

 private:
  openvdb::FloatGrid::ConstPtr mPhi;
  std::optional<ThicknessFinder> mFinder;
  std::map<double, LocalThickness> mThickness;  ///< by the slope
};

/// The local thickness as a control: that of the nearest point of the grid's box beyond it.
Control thicknessControl(const LocalThickness& thickness);

/// A closed mesh in brief, as --origin auto and --detail see it at the usual resolution.
struct SolidShape {
  InscribedBall deepest;                             ///< world units
  double leastThickness = 0, greatestThickness = 0;  ///< world units
};
/// None if the mesh is too thin for that resolution, or no solid.
std::optional<SolidShape> shapeOfSolid(const Mesh& mesh, const MeshReport& report);

/// The volume of phi < 0, world units cubed, exact to a small part of the voxels that the surface meets. Serves narrow
/// bands, too.
double insideVolume(const openvdb::FloatGrid& phi);
/// The same of the part within a box, whose sides are parallel to those of the voxels.
double insideVolume(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

}  // namespace vdbtools
