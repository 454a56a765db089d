// SPDX-License-Identifier: Apache-2.0
/// @file fit_measure.h
/// How well a rational map fits a target after one iteration (n = 1): by volume, by distance, and by the energy of
/// [Kim15] Eq. 5.
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

/// The iterations of iteratedIou().
inline constexpr int kScoredIterations = 4;

/// FitMeasure::iou of the set after kScoredIterations iterations, up to the escape radius 20: of the Julia set that the
/// map is fitted for.
/// @throw std::invalid_argument  as julia::requireFinite()
/// @throw Interrupted
double iteratedIou(const FitTarget& target, const julia::Rational& rational, Monitor& monitor);

}  // namespace vdbtools::fit
