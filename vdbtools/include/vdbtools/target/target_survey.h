// SPDX-License-Identifier: Apache-2.0
/// @file target_survey.h
/// Global properties of a target: its deepest point, its local thickness, and its volume. They are computed from
/// distances over its whole inside on a coarse lattice, which costs little compared with the fine distances near the
/// surface.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/control/control.h"
#include "vdbtools/exponent/local_thickness.h"
#include "vdbtools/target/inscribed_ball.h"

#include <map>
#include <memory>
#include <optional>
#include <utility>

namespace vdbtools {

class TargetSurvey {
 public:
  /// @param phi   world units, negative inside, known over the whole inside and a few voxels outside
  /// @param mesh  the mesh that phi was made from, if it is known
  /// @param thickness  finds the thickness of phi's inside, if it is known
  explicit TargetSurvey(openvdb::FloatGrid::ConstPtr phi, std::shared_ptr<const Mesh> mesh = nullptr,
                        std::optional<ThicknessFinder> thickness = {})
      : mPhi(std::move(phi)), mMesh(std::move(mesh)), mFinder(std::move(thickness)) {}

  const openvdb::FloatGrid::ConstPtr& phi() const { return mPhi; }

  /// @throw DataError  as largestInscribedBall()
  InscribedBall largestBall(const openvdb::Vec3d& preferred) const {
    return largestInscribedBall(*mPhi, preferred, mMesh.get());
  }

  /// The local thickness for a slope. It is computed on the first request and cached until a few other slopes have been
  /// requested.
  /// @throw DataError, Interrupted  as localThickness()
  LocalThickness thickness(Monitor& monitor, double slope = kThicknessSlope);

 private:
  openvdb::FloatGrid::ConstPtr mPhi;
  std::shared_ptr<const Mesh> mMesh;
  std::optional<ThicknessFinder> mFinder;
  std::map<double, LocalThickness> mThickness;  ///< by the slope
};

/// The local thickness as a control. Points outside the grid's box get the thickness of its nearest point.
Control thicknessControl(const LocalThickness& thickness);

/// The extremes of a closed mesh, as --origin auto and --detail see it at the usual resolution.
struct SolidShape {
  InscribedBall deepest;                             ///< world units
  double leastThickness = 0, greatestThickness = 0;  ///< world units
};
/// Returns nullopt if the mesh is too thin for that resolution, or not a solid.
std::optional<SolidShape> shapeOfSolid(const Mesh& mesh, const MeshReport& report);

/// The volume of phi < 0, world units cubed, exact up to a small part of the voxels that the surface cuts. Narrow bands
/// suffice.
double insideVolume(const openvdb::FloatGrid& phi);
/// The volume of the part within a box, whose sides are parallel to the voxels' sides.
double insideVolume(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

}  // namespace vdbtools
