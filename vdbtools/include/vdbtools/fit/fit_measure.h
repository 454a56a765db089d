// SPDX-License-Identifier: Apache-2.0
/// @file fit_measure.h
/// How well a rational map fits a target after one iteration (n = 1): by volume, by distance, and by the energy of
/// [Kim15] Eq. 5.
#pragma once

#include "vdbtools/fit/fit_target.h"

#include "julia/rational.h"

#include <cstdint>

namespace vdbtools::fit {

/// Over the cells of the target's cube. A cell is inside the map where L = ln|R| < 0 at its middle, slice 0, k dropped.
struct FitMeasure {
  double iou = 0;                ///< cells inside both over cells inside either
  std::uint64_t wrongCells = 0;  ///< inside only one of the two
  /// Between the surface L = 0 within the cube and the target's, fractal space: the mean of the two directions' means,
  /// and the largest of either (Hausdorff). They are read off the cells, so they are good to a fraction of one.
  /// Infinite if L is 0 nowhere.
  double meanDistance = 0, hausdorff = 0;
  /// (1/eta) sum -tanh(a L) W, W = 1/phi with |phi| at least half a cell, eta = sum |W|: -1 is a perfect fit.
  double psi = 0;
};

/// @param rational   in fractal space
/// @param sharpness  a > 0
/// @throw std::invalid_argument  sharpness not positive, or as julia::requireFinite()
/// @throw Interrupted
FitMeasure measureFit(const FitTarget& target, const julia::Rational& rational, double sharpness, Monitor& monitor);

}  // namespace vdbtools::fit
