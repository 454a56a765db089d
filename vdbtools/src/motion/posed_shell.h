// SPDX-License-Identifier: Apache-2.0
/// @file posed_shell.h
/// The shell about a target at rest, carried to the target in a pose (surface_motion.h).
///
/// Where the fate of a point is undecided, rho is found at the nodes of a lattice about the pose and interpolated
/// between them. In cells over which rho jumps, because two parts of the surface are equally near, it is found at each
/// point instead. Farther from the surface the side on which a point lies decides.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/motion/surface_motion.h"

#include "julia/deformed_evaluator.h"

#include <memory>

namespace vdbtools {

/// How far the shell reaches to either side of the target at rest, world units.
DetailReach reachAtRest(const ExponentGrid& exponent, const Target& atRest);

struct PosedShell {
  /// For plans only: where the carried exponent is undecided, this one is too.
  ExponentGrid exponent;
  std::shared_ptr<const julia::Deformation> deformation;  ///< from points of the space at rest, to the same
  double jumps = 0;                                       ///< the part of the undecided cells over which rho jumps
};

/// @param reach   as reachAtRest()
/// @param pose    in a band of the motion's greatestGrowth() times the reach
/// @throw Interrupted
PosedShell posedShell(const ExponentGrid& exponent, const DetailReach& reach, const Target& pose,
                      std::shared_ptr<SurfaceMotion> motion, Monitor& monitor);

}  // namespace vdbtools
