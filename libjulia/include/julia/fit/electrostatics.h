// SPDX-License-Identifier: Apache-2.0
/// @file electrostatics.h
/// The potential of a charged conductor ([Kim15] Eqs. 11 to 13): P = 1 on a surface, harmonic outside it, 0 at
/// infinity.
///
/// The method is the boundary element method: P is the single layer potential sum_j s_j integral_j dy / |x - y| with a
/// constant density s_j on each triangle, and P = 1 at every centroid. Near integrals are evaluated in closed form
/// (edge logarithms and the solid angle), far ones by a quadrature rule of 7 nodes, within 2e-7 of their values. The
/// constant densities cause the error of the potential, and with it that of the capacitance: on even meshes it is
/// proportional to the length of the edges.
#pragma once

#include "julia/fit/surface.h"

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace julia {

struct ElectrostaticsOptions {
  /// Up to this many triangles the system is solved directly, with 8 bytes for each pair of triangles and a residual of
  /// about 1e-15. Larger systems are solved iteratively, in a time that grows with the square of the number of
  /// triangles instead of the cube: for 6000 triangles, a fifth of the time or less.
  std::size_t maxDense = 1500;
  /// The residual |A s - 1| / |1| at which the iteration stops. The smallest value is 1e-7, because the coefficients
  /// have 32 bits.
  double tolerance = 1e-6;
  int maxIterations = 500;
  /// The maximum memory for the coefficients of the iteration, which take 4 bytes for each pair of triangles.
  /// Coefficients that do not fit are recomputed in every step, which is slow but changes no bit.
  std::size_t maxStoredBytes = std::size_t{2} << 30;
  /// Called from time to time, by several threads at once; if it returns true, the work ends.
  std::function<bool()> cancelled;
};

struct SurfaceCharge {
  /// The density of each triangle, per unit of area; 0 for triangles that are left out because they are thinner than
  /// 1e-9 of their length.
  std::vector<double> density;
  double capacitance = 0;  ///< the total charge, in units of the map's space; for a sphere it is the radius
  int iterations = 0;      ///< 0 where the system was solved directly
  double residual = 0;     ///< |A s - 1| / |1|, root mean square over the centroids
};

/// Solves for the charge that gives P = 1. The same surface gives the same bytes for any number of threads and on any
/// machine.
/// @throw std::invalid_argument  as requireValid(); no triangle with area, an option out of its domain, or no solution
///                               within maxIterations
/// @throw Cancelled              options.cancelled returned true
SurfaceCharge solveExteriorDirichlet(const TriangleSurface& surface, const ElectrostaticsOptions& options = {});

/// Sets p to P at the points @a x, which may lie anywhere; inside a closed surface it is nearly 1.
/// @throw std::invalid_argument  as requireValid(); different sizes, or a point that is not between -1e9 and 1e9
void potential(const TriangleSurface& surface, const SurfaceCharge& charge, std::span<const Point> x,
               std::span<double> p);

}  // namespace julia
