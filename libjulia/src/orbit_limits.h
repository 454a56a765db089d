// SPDX-License-Identifier: Apache-2.0
/// @file orbit_limits.h
/// The limits by which an orbit ends, in the type that it is computed in.
#pragma once

#include "julia/elementary.h"
#include "julia/orbit.h"

#include <limits>

namespace julia {

template <class Real>
struct OrbitLimits {
  explicit OrbitLimits(const OrbitOptions& options)
      : escapeSquared(static_cast<Real>(options.escapeRadius * options.escapeRadius)),
        nearSquared(escapeSquared * (1 - 8 * std::numeric_limits<Real>::epsilon())),
        logEscape(static_cast<Real>(elementary::log(options.escapeRadius))),
        logTrap(static_cast<Real>(options.logTrap)) {}

  Real escapeSquared;
  Real nearSquared;  ///< below this, a point has not escaped, in whichever order squares are added
  Real logEscape, logTrap;
};

/// F of an orbit from its last l and the map's level.
template <class Real>
double fieldOfEnd(Real l, Real level) {
  const double value = static_cast<double>(l - level);
  const double above = value > -kFieldLimit ? value : -kFieldLimit;
  return above < kFieldLimit ? above : kFieldLimit;
}

}  // namespace julia
