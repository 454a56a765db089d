// SPDX-License-Identifier: Apache-2.0
#include "julia/detail.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {

double wantedScale(const RadialMaximum& maximum, int maxIterations, double escapeRadius) {
  // A larger K leaves practically no shell.
  constexpr double kMost = 1e4, kLeast = 0.25;
  constexpr double kRatio = 1.05, kPrecision = 1e-4;
  const double upper = elementary::log(escapeRadius);
  const auto traps = [&](double scale) {
    RadialMaximum exponent = maximum;
    for (double& value : exponent.maximum) value = upper + scale * value;
    return upper - scale <= shellInterval(exponent, maxIterations, escapeRadius).lower;
  };
  double scale = kLeast;
  while (!traps(scale)) {
    scale *= kRatio;
    if (scale > kMost)
      throw NoDetail("no shell of detail traps orbits about the origin, up to a scale of " + std::to_string(kMost) +
                     "; the origin must lie inside the target");
  }
  double low = scale / kRatio;
  while (scale - low > kPrecision * scale) {
    const double middle = (low + scale) / 2;
    (traps(middle) ? scale : low) = middle;
  }
  return scale;
}

DetailLaw wantedLaw(const RadialMaximum& maximum, double surface, int maxIterations, double escapeRadius) {
  // The distance from which orbits are seen to leave, as a fraction of the target's depth about the origin.
  constexpr double kLeaving = 0.7;
  constexpr double kMost = 100, kPrecision = 1e-3;
  DetailLaw law{.logEscape = elementary::log(escapeRadius),
                .scale = wantedScale(maximum, maxIterations, escapeRadius),
                .plunge = 0};
  const auto reached = std::find_if(maximum.maximum.begin(), maximum.maximum.end(),
                                    [surface](double value) { return value >= surface; });
  const double depth = maximum.step * static_cast<double>(reached - maximum.maximum.begin() + 1);
  const double gentle = (law.logEscape - elementary::log(kLeaving * depth)) / (1 - DetailLaw::kPlunge);
  if (!(gentle > 0 && gentle < law.scale)) return law;
  const auto traps = [&](double plunge) {
    const DetailLaw tried{law.logEscape, gentle, plunge};
    RadialMaximum exponent = maximum;
    for (double& value : exponent.maximum) value = tried.at(value);
    return tried.at(-1) <= shellInterval(exponent, maxIterations, escapeRadius).lower;
  };
  if (!traps(kMost)) return law;
  double low = 0, high = kMost;
  while (high - low > kPrecision * (gentle + low)) {
    const double middle = (low + high) / 2;
    (traps(middle) ? high : low) = middle;
  }
  return {law.logEscape, gentle, high};
}

}  // namespace julia
