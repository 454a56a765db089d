// SPDX-License-Identifier: Apache-2.0
/// @file fit_measure.h
/// How well a rational map fits a target: after one iteration (n = 1) by volume, by distance, and by the energy of
/// [Kim15] Eq. 5; after more of them by volume.
#pragma once

#include "vdbtools/fit/fit_target.h"

#include "julia/rational.h"

#include <cstdint>

namespace vdbtools::fit {

/// Measured over the cells of the target's cube. A cell is inside the map if L = ln|R| < 0 at its centre, with slice 0
/// and k dropped.
struct FitMeasure {
  double iou = 0;                ///< cells inside both divided by cells inside either
  std::uint64_t wrongCells = 0;  ///< number of cells inside only one of the two
  /// Distances between the surface L = 0 within the cube and the target's, fractal space: the average of the mean
  /// distances in the two directions, and the maximum of either (Hausdorff). They are measured on the cells, so they
  /// are accurate to a fraction of a cell. Infinite if L is 0 nowhere.
  double meanDistance = 0, hausdorff = 0;
  /// (1/eta) sum -tanh(a L) W, W = 1/phi with |phi| at least half a cell, eta = sum |W|: -1 is a perfect fit.
  double psi = 0;
};

/// @param rational   the map, in fractal space
/// @param sharpness  a > 0
/// @throw std::invalid_argument  sharpness not positive, or as julia::requireFinite()
/// @throw Interrupted
FitMeasure measureFit(const FitTarget& target, const julia::Rational& rational, double sharpness, Monitor& monitor);

struct IteratedOptions {
  int iterations = 4;  ///< n, 1 or more; the escape radius is 20
  int every = 1;       ///< counts only every n-th cell along each axis, where n is this number: 1 / n^3 of all cells
};

/// FitMeasure::iou of the set after n iterations.
/// @throw std::invalid_argument  as julia::requireFinite()
/// @throw Interrupted
double iteratedIou(const FitTarget& target, const julia::Rational& rational, const IteratedOptions& options,
                   Monitor& monitor);

/// The number to add to C so that the set after n iterations has the largest IoU. A point inside the target stays in
/// the set only if its whole orbit stays inside, but the first step sends it to |R| < 1 in any direction, where the
/// shape may end sooner. A smaller C keeps orbits nearer to the middle, so that fewer points are lost, but it also lets
/// points from farther out into the set. The best balance is searched on some thousands of cells, to about 0.02.
/// @return 0 for n = 1, for which the map was fitted
/// @throw  as iteratedIou()
double scaleShift(const FitTarget& target, const julia::Rational& rational, int iterations, Monitor& monitor);

}  // namespace vdbtools::fit
