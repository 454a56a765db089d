// SPDX-License-Identifier: Apache-2.0
/// @file detail.h
/// The exponent E for a wanted depth of detail: the distance-radius relation of [SK23] Fig. 8, solved the other way
/// round (docs/design.md 2.8).
///
/// Let w(x) be 0 where detail shall end outside the target and -1 where it shall end inside, so that the shell of
/// detail is -1 < w < 0; w increases outward. With a scale K > 0,
///
///   E(x) = ln(escape) + K w(x)
///
/// Where w >= 0 the first iterate has escaped, so that the point is outside. Where w <= -1 it must be trapped:
///
///   ln(escape) - K <= ln r_in     r_in: the trapped ball of shell.h, which depends on E itself
///
/// Nothing less than the escape radius will do outside: a quaternion far from the origin may have its first three
/// coordinates, where E is read, anywhere. The smaller K is, the rougher is the detail that fills the shell.
#pragma once

#include "julia/shell.h"

#include <stdexcept>

namespace julia {

/// No shell of detail traps orbits about an origin.
class NoDetail : public std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// The smallest K.
/// @param maximum  of w
/// @throw NoDetail  no K up to 1e4 traps a ball: w is not below 0 about the origin
/// @throw std::invalid_argument  maxIterations < 1 or escapeRadius <= 1
double wantedScale(const RadialMaximum& maximum, int maxIterations, double escapeRadius);

}  // namespace julia
