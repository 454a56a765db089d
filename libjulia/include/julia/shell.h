// SPDX-License-Identifier: Apache-2.0
/// @file shell.h
/// The region where F must be computed (docs/design.md 2.4). For the shape modulus |q_{i+1}| = e^E(q_i). Hence, with
///
///   m(r) = max over |y| <= r of e^E(y)
///
/// a point whose first iterate has l <= ln r_in is inside, where r_in is the largest r < 1 that stays < 1 when m is
/// applied to it n - 1 times. A point with l >= ln(escape) is outside. Only points where E lies in the open interval
/// (ln r_in, ln escape) are undecided.
#pragma once

#include <limits>
#include <span>
#include <vector>

namespace julia {

struct ShellInterval {
  double lower = -std::numeric_limits<double>::infinity();  ///< ln r_in; -inf if no ball about the origin is trapped
  double upper = std::numeric_limits<double>::infinity();   ///< ln escape
};

/// Upper bounds of E over balls about the origin, as a step function: maximum[k] bounds E over |y| <= (k + 1) step.
struct RadialMaximum {
  double step = 0;              ///< units of the map's space, > 0
  std::vector<double> maximum;  ///< non-decreasing; beyond its end E is unbounded

  /// A bound of ln m(r); +inf past the end of the table.
  double logBound(double r) const;
};

/// Returns the undecided interval of E for orbits of at most @a maxIterations steps.
/// @throw std::invalid_argument unless maxIterations >= 1 and escapeRadius > 1
ShellInterval shellInterval(const RadialMaximum& radialMaximum, int maxIterations, double escapeRadius);

}  // namespace julia
