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

#include "julia/bricks.h"
#include "julia/shell.h"

#include <algorithm>
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
///   E = v + (P / (kPlunge K)) min(v - v(kPlunge - 1), 0)    with v(w) = ln(escape) + K w
///
/// v is what lattices store. As E follows it at each point that is read, and not only at nodes, what is promised at w =
/// 0 and w = -1 holds between nodes, too, and the plunge may be thinner than a cell.
struct DetailLaw {
  double logEscape = 0;
  double scale = 0;   ///< K
  double plunge = 0;  ///< P >= 0; 0: E = v
  static constexpr double kPlunge = 0.05;

  /// v(w)
  double line(double w) const { return logEscape + scale * w; }
  /// How E bends where it is read.
  Knee knee() const { return {.at = line(kPlunge - 1), .more = plunge / (kPlunge * scale)}; }
  /// E
  double at(double w) const { return line(w) + plunge / kPlunge * std::min(w + 1 - kPlunge, 0.0); }
};

/// Returns the law with the smallest scale, and the plunge that it needs.
/// @param maximum  bounds of w
/// @param surface  w at the target's surface; the depth of the target about the origin is read from @a maximum
/// @throw NoDetail  as wantedScale()
/// @throw std::invalid_argument  as wantedScale()
DetailLaw wantedLaw(const RadialMaximum& maximum, double surface, int maxIterations, double escapeRadius);

}  // namespace julia
