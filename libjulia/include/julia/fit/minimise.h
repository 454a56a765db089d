// SPDX-License-Identifier: Apache-2.0
/// @file minimise.h
/// The optimiser of [Kim15] 4.5: the limited-memory quasi-Newton method with bounds (L-BFGS-B, by LBFGSpp) on the shape
/// energy. Its variables are the powers, tau, beta and C; all except C stay at 0 or above. The positions of the roots,
/// which the paper keeps, are the variables of moveRoots().
#pragma once

#include "julia/fit/shape_energy.h"

#include <functional>
#include <span>

namespace julia {

enum class FitVariables {
  Coarse,  ///< C, tau and beta: the variable-coarsened passes
  Full,    ///< the powers as well
};

struct MinimiseOptions {
  int maxIterations = 500;  ///< 0 or more
  double tolerance = 1e-6;  ///< the optimiser stops when ten steps lower the energy by less than this
  /// Called whenever the energy reaches a new minimum. An exception from it ends the work.
  std::function<void(double energy, const Rational& rational)> onStep;
  std::function<bool()> cancelled;  ///< asked at each evaluation
};

/// Lowers the energy.
/// @param energy     the function to minimise
/// @param rational   in: the starting point; negative variables are taken as 0. Out: the best rational found
/// @param variables  which variables change
/// @param options    see MinimiseOptions
/// @return the energy of the best rational
/// @throw Cancelled              options.cancelled returned true
/// @throw std::invalid_argument  a number of the rational is not finite, the number of its roots differs from that of
///                               the energy, or an option is out of its domain
double minimise(const ShapeEnergy& energy, Rational& rational, FitVariables variables, const MinimiseOptions& options);

/// Lowers the energy by moving the roots within their slice. Powers, scales and C stay as they are.
/// @param energy    the function to minimise; its roots become those of the rational
/// @param rational  in: the starting point; out: the best rational found
/// @param reach     for each root, top roots first, how far each of its coordinates may move from its start: 0 or more,
///                  units of the map's space
/// @param options   see MinimiseOptions
/// @return the energy of the best rational
/// @throw Cancelled              options.cancelled returned true
/// @throw std::invalid_argument  as minimise(), or reaches out of their domain
double moveRoots(ShapeEnergy& energy, Rational& rational, std::span<const double> reach,
                 const MinimiseOptions& options);

}  // namespace julia
