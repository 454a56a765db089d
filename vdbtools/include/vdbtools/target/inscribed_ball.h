// SPDX-License-Identifier: Apache-2.0
/// @file inscribed_ball.h
/// The largest ball inside a shape. Its centre is the default origin of the dynamics: [SK23] assumes throughout that
/// the origin lies inside the target, and the deeper it lies, the larger is the ball that traps orbits (docs/design.md
/// 2.4).
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/mesh/mesh.h"

namespace vdbtools {

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

}  // namespace vdbtools
