// SPDX-License-Identifier: Apache-2.0
/// @file electrostatics.h
/// The potential of a charged conductor ([Kim15] Eqs. 11 to 13): P = 1 on a surface, harmonic outside it, 0 at
/// infinity.
///
/// The method is that of boundary elements: P is the single layer sum_j s_j integral_j dy / |x - y| with a constant
/// density s_j on each triangle, and P = 1 at every centroid. Near integrals are evaluated in closed form (edge
/// logarithms and the solid angle), far ones by a rule of 7 nodes, within 2e-7 of their values. The error of the
/// potential, and with it that of the capacitance, is due to the constant densities: on even meshes it falls in
/// proportion to the length of the edges.
#pragma once

#include "julia/fit/surface.h"

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace julia {

struct ElectrostaticsOptions {
  /// Up to this many triangles the system is solved directly, with 8 bytes for each pair of them and a residual of
  /// about 1e-15. Beyond, it is solved iteratively, in a time that grows with the square of their number instead of the
  /// cube: at 6000 triangles a fifth or less.
  std::size_t maxDense = 1500;
  /// The residual |A s - 1| / |1| at which the iteration stops. The least is 1e-7, as it uses 32-bit coefficients.
  double tolerance = 1e-6;
  int maxIterations = 500;
  /// The most memory for the coefficients of the iteration, which take 4 bytes for each pair of triangles. Coefficients
  /// beyond it are computed in every step, which takes long but changes no bit.
  std::size_t maxStoredBytes = std::size_t{2} << 30;
  /// Called now and then, in several threads at once; if it returns true, the work ends.
  std::function<bool()> cancelled;
};

struct SurfaceCharge {
  /// For each triangle, per unit of area; 0 for triangles that are left out, being thinner than 1e-9 of their length.
  std::vector<double> density;
  double capacitance = 0;  ///< the whole charge, in units of the map's space; for a sphere it is the radius
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
