// SPDX-License-Identifier: Apache-2.0
/// @file minimise.h
/// The optimiser of [Kim15] 4.5: the limited-memory quasi-Newton method with bounds (L-BFGS-B, by LBFGSpp) on the shape
/// energy. Its variables are the powers, tau, beta and C; all except C stay at 0 or above.
#pragma once

#include "julia/fit/shape_energy.h"

#include <functional>

namespace julia {

enum class FitVariables {
  Coarse,  ///< C, tau and beta: the variable-coarsened passes
  Full,    ///< the powers as well
};

struct MinimiseOptions {
  int maxIterations = 500;  ///< 0 or more
  double tolerance = 1e-6;  ///< the optimiser stops when ten steps lower the energy by less than this
  /// Called wherever the energy is lower than ever before. An exception from it ends the work.
  std::function<void(double energy, const Rational& rational)> onStep;
  std::function<bool()> cancelled;  ///< asked at each evaluation
};

/// Lowers the energy.
/// @param energy     what is lowered
/// @param rational   in: where to start; negative variables are taken as 0. Out: the best that was found
/// @param variables  which variables change
/// @param options    see MinimiseOptions
/// @return the energy of the best
/// @throw Cancelled              options.cancelled returned true
/// @throw std::invalid_argument  a number of the rational is not finite, its roots are not as many as the energy's, or
/// an
///                               option is out of its domain
double minimise(const ShapeEnergy& energy, Rational& rational, FitVariables variables, const MinimiseOptions& options);

}  // namespace julia
