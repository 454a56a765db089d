// SPDX-License-Identifier: Apache-2.0
/// @file minimise.h
/// The optimiser of [Kim15] 4.5: a quasi-Newton method of limited memory with bounds (L-BFGS-B, by LBFGSpp) on the
/// shape energy, over the powers, tau, beta and C, of which all but C stay 0 or above.
#pragma once

#include "julia/fit/shape_energy.h"

#include <functional>

namespace julia {

enum class FitVariables {
  Coarse,  ///< C, tau and beta: the variable-coarsened passes
  Full,    ///< the powers too
};

struct MinimiseOptions {
  int maxIterations = 500;  ///< 0 or more
  double tolerance = 1e-6;  ///< stops where ten steps lower the energy by less than this
  /// Called where the energy is lower than anywhere before. What it throws ends the work.
  std::function<void(double energy, const Rational& rational)> onStep;
  std::function<bool()> cancelled;  ///< asked at each evaluation
};

/// Lowers the energy from @a rational on, whose negative variables are taken as 0, and leaves there the best that was
/// found. @return the energy there
/// @throw Cancelled
/// @throw std::invalid_argument  a number of the rational is not finite, it has not the energy's roots, or options out
///                               of their domain
double minimise(const ShapeEnergy& energy, Rational& rational, FitVariables variables, const MinimiseOptions& options);

}  // namespace julia
