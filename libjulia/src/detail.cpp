// SPDX-License-Identifier: Apache-2.0
#include "julia/detail.h"

#include "julia/elementary.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {

double wantedScale(const RadialMaximum& maximum, int maxIterations, double escapeRadius) {
  // A larger K leaves no shell to speak of.
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

}  // namespace julia
