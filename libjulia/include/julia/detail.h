// SPDX-License-Identifier: Apache-2.0
/// @file detail.h
/// The exponent E for a wanted depth of detail: the distance-radius relation of [SK23] Fig. 8, solved the other way
/// round (docs/design.md 2.8).
///
/// Let w(x) be a function that increases outward. It is 0 where detail shall end outside the target and -1 where it
/// shall end inside, so that the shell of detail is -1 < w < 0. With a scale K > 0,
///
///   E(x) = ln(escape) + K w(x)
///
/// Where w >= 0 the first iterate has escaped, so that the point is outside. Where w <= -1 the orbit must be trapped:
///
///   ln(escape) - K <= ln r_in     r_in: the trapped ball of shell.h, which depends on E itself
///
/// Outside, nothing less than the escape radius suffices: even for a quaternion far from the origin, the first three
/// coordinates, where E is read, may be small. The smaller K is, the rougher is the detail that fills the shell.
#pragma once

#include "julia/shell.h"

#include <functional>
#include <stdexcept>

namespace julia {

/// Thrown if no shell of detail traps orbits about the origin.
class NoDetail : public std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Returns the smallest K.
/// @param maximum  bounds of w
/// @throw NoDetail  no K up to 1e4 traps a ball: w is not below 0 about the origin
/// @throw std::invalid_argument  maxIterations < 1 or escapeRadius <= 1
double wantedScale(const RadialMaximum& maximum, int maxIterations, double escapeRadius);

/// E as a function of w. The bound r_in assumes an orbit that takes the worst direction at each step, and few orbits
/// do: with the law above, and D = 0.8, no point deeper than about 65 % of the shell ever leaves. In a deep shell, E
/// therefore falls slowly at first, down to where orbits do leave, and then plunges to ln r_in in the last kPlunge of
/// the shell:
///
///   E = ln(escape) + K w                      for -(1 - kPlunge) <= w <= 0
///   E = ln(escape) - K + S (w + 1) - P        below, with S = K + P / kPlunge
///   E = ln(escape) + S w                      above 0, where only its sign matters
///
/// Lines of slope S through (-1, E(-1)) and through (0, E(0)) lie above and below E, respectively. Hence, if a mean of
/// w over nodes is <= -1, the same mean of E is at most E(-1); if it is >= 0, the mean of E is at least ln(escape).
/// What is promised at nodes therefore also holds between them.
struct DetailLaw {
  double logEscape = 0;
  double scale = 0;   ///< K
  double plunge = 0;  ///< P >= 0; 0: E is linear
  static constexpr double kPlunge = 0.05;

  double at(double w) const {
    const double steep = scale + plunge / kPlunge;
    if (w > 0) return logEscape + steep * w;
    if (w >= kPlunge - 1) return logEscape + scale * w;
    return logEscape - scale + steep * (w + 1) - plunge;
  }
};

/// Returns the law with the smallest scale, and the plunge that it needs.
/// @param maximum  bounds of w
/// @param surface  w at the target's surface; the depth of the target about the origin is read from @a maximum
/// @param under    bounds of E under a law. With a plunge these are not the law of bounds of w, if E is interpolated
///                 between nodes at which the law was applied. If empty, the law applies everywhere.
/// @throw NoDetail  as wantedScale()
/// @throw std::invalid_argument  as wantedScale()
DetailLaw wantedLaw(const RadialMaximum& maximum, double surface, int maxIterations, double escapeRadius,
                    const std::function<RadialMaximum(const DetailLaw&)>& under = {});

}  // namespace julia
