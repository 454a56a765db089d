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
  constexpr double kRatio = 1.05, kPrecision = 1e-6;
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

namespace {

/// The radius of the ball in which the bound first reaches a value; between the table's balls it is taken as linear.
double firstReach(const RadialMaximum& table, double value) {
  const std::vector<double>& maximum = table.maximum;
  const auto reached = std::lower_bound(maximum.begin(), maximum.end(), value);
  const auto ball = static_cast<double>(reached - maximum.begin());
  if (reached == maximum.begin() || reached == maximum.end()) return table.step * (ball + 1);
  const double before = *(reached - 1);
  return table.step * (ball + (std::isfinite(before) ? (value - before) / (*reached - before) : 1));
}

}  // namespace

DetailLaw wantedLaw(const RadialMaximum& maximum, double surface, int maxIterations, double escapeRadius) {
  // The distance from which orbits are seen to leave, as a fraction of the target's depth about the origin.
  constexpr double kLeaving = 0.7;
  constexpr double kMost = 100, kPrecision = 1e-3;
  DetailLaw law{.logEscape = elementary::log(escapeRadius),
                .scale = wantedScale(maximum, maxIterations, escapeRadius),
                .plunge = 0};
  const double depth = firstReach(maximum, surface);
  const double gentle = (law.logEscape - elementary::log(kLeaving * depth)) / (1 - DetailLaw::kPlunge);
  if (!(gentle > 0 && gentle < law.scale)) return law;
  const auto traps = [&](const DetailLaw& tried) {
    RadialMaximum exponent = maximum;
    for (double& value : exponent.maximum) value = tried.at(value);
    return tried.at(-1) <= shellInterval(exponent, maxIterations, escapeRadius).lower;
  };
  DetailLaw tried{law.logEscape, gentle, kMost};
  double low = 0;
  if (!traps(tried)) return law;
  while (tried.plunge - low > kPrecision * (gentle + low)) {
    const DetailLaw middle{law.logEscape, gentle, (low + tried.plunge) / 2};
    (traps(middle) ? tried.plunge : low) = middle.plunge;
  }
  return tried;
}

}  // namespace julia
