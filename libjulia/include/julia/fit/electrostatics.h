// SPDX-License-Identifier: Apache-2.0
/// @file electrostatics.h
/// The potential of a charged conductor ([Kim15] Eqs. 11 to 13): P = 1 on a surface, harmonic outside it, 0 at
/// infinity.
///
/// Boundary elements: P is the single layer sum_j s_j integral_j dy / |x - y| with a constant density s_j on each
/// triangle, and 1 at every centroid. Near integrals are in closed form (edge logarithms and the solid angle), far ones
/// by a rule of 7 nodes, within 2e-7 of their values. The potential's own error is that of the constant densities: on
/// even meshes it falls as the length of the edges, and with it the capacitance's.
#pragma once

#include "julia/fit/surface.h"

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace julia {

struct ElectrostaticsOptions {
  /// Up to so many triangles the system is solved directly, with 8 bytes for each pair of them and a residual of some
  /// 1e-15. The iteration's time grows with the square of their number instead of the cube: a fifth or less at 6000.
  std::size_t maxDense = 1500;
  /// Of the residual |A s - 1| / |1| where the iteration stops. It works on 32-bit coefficients: 1e-7 is the least.
  double tolerance = 1e-6;
  int maxIterations = 500;
  /// Most memory for the coefficients of the iteration, 4 bytes for each pair of triangles. Those beyond it are worked
  /// out anew in every step, which takes long and changes no bit.
  std::size_t maxStoredBytes = std::size_t{2} << 30;
  /// Asked now and then, in several threads at once; true ends the work.
  std::function<bool()> cancelled;
};

struct SurfaceCharge {
  /// Of each triangle, per unit of area; 0 for triangles left out because they are thinner than 1e-9 of their length.
  std::vector<double> density;
  double capacitance = 0;  ///< the whole charge, in units of the map's space: a sphere's is its radius
  int iterations = 0;      ///< 0 where the system was solved directly
  double residual = 0;     ///< |A s - 1| / |1|, root mean square over the centroids
};

/// The same surface gives the same bytes for any number of threads and on any machine.
/// @throw std::invalid_argument  as requireValid(), no triangle with area, an option out of its domain, or no solution
///                               within maxIterations
/// @throw Cancelled              options.cancelled said so
SurfaceCharge solveExteriorDirichlet(const TriangleSurface& surface, const ElectrostaticsOptions& options = {});

/// P at points @a x anywhere; inside a closed surface it is nearly 1.
/// @throw std::invalid_argument  as requireValid(), sizes that differ, or a point that is not between -1e9 and 1e9
void potential(const TriangleSurface& surface, const SurfaceCharge& charge, std::span<const Point> x,
               std::span<double> p);

}  // namespace julia
