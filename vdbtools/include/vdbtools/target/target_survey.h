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
#include "vdbtools/mesh/mesh.h"

#include <map>
#include <memory>
#include <optional>
#include <utility>

namespace vdbtools {

// The largest ball inside a shape. Its centre is the default origin of the dynamics: [SK23] assumes throughout that
// the origin lies inside the target, and the deeper it lies, the larger is the ball that traps orbits (docs/design.md
// 2.4).

struct InscribedBall {
  openvdb::Vec3d centre{0, 0, 0};  ///< world units
  double radius = 0;               ///< distance from the centre to the surface, world units
};

/// Of two balls, the one farther from the preferred point must be larger by about this share of the difference of
/// the two distances. The choice therefore moves continuously along parts of constant thickness, and among nearly equal
/// balls it is the nearest.
inline constexpr double kInscribedBallPull = 0.03;
/// A second, weaker pull, along the direction (0.8, 0.48, 0.36), for balls that are equally large and equally far from
/// the preferred point, like those in a torus: it makes one of them the best. Where one ball at the preferred point is
/// among the best, as in a box, it stays so, since the pull toward it is stronger in every direction.
inline constexpr double kInscribedBallTieBreak = 0.01;

/// Returns the ball that maximises its radius, minus kInscribedBallPull times the distance from its centre to @a
/// preferred, plus kInscribedBallTieBreak times its way from there along the direction above. No other ball anywhere
/// scores better by more than 1/1000 of a voxel. If a shape has several parts, it is in the deepest.
/// @param phi        world units, negative inside; the distances must be known over the whole inside
/// @param preferred  world units, usually the middle of the shape's box
/// @param mesh       the mesh that phi was made from, world units: the ball then touches its triangles, so that it does
///                   not depend on the lattice. nullptr, or a mesh that phi does not agree with: it touches phi = 0
/// @throw DataError  phi is nowhere negative
InscribedBall largestInscribedBall(const openvdb::FloatGrid& phi, const openvdb::Vec3d& preferred,
                                   const Mesh* mesh = nullptr);

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
