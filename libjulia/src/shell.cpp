// SPDX-License-Identifier: Apache-2.0
#include "julia/shell.h"

#include "julia/elementary.h"
#include "julia/orbit.h"

#include <algorithm>
#include <cmath>

namespace julia {

double RadialMaximum::logBound(double r) const {
  // The smallest ball of the table that contains the ball of radius r.
  const double index = std::max(0.0, std::ceil(r / step) - 1);
  if (!(index < static_cast<double>(maximum.size()))) return std::numeric_limits<double>::infinity();
  return maximum[static_cast<std::size_t>(index)];
}

ShellInterval shellInterval(const RadialMaximum& radialMaximum, int maxIterations, double escapeRadius) {
  requireValid(OrbitOptions{.maxIterations = maxIterations, .escapeRadius = escapeRadius});
  // Whether the first image, given the logarithm of its bound, and the n - 2 images that follow stay below 1.
  const auto staysInside = [&](double l) {
    for (int i = 2; l < 0 && i < maxIterations; ++i) l = radialMaximum.logBound(elementary::exp(l));
    return l < 0;
  };
  ShellInterval interval;
  interval.upper = elementary::log(escapeRadius);
  // With one step every l < 0 is inside. Otherwise staysInside() is a step function of r that changes once from true to
  // false, at one of the table's balls; its last true step is the answer.
  if (maxIterations == 1) {
    interval.lower = 0;
    return interval;
  }
  const std::vector<double>& maximum = radialMaximum.maximum;
  const double inUnitBall = std::max(0.0, std::ceil(1 / radialMaximum.step) - 1);
  const auto end =
      maximum.begin() + static_cast<std::ptrdiff_t>(std::min(inUnitBall, static_cast<double>(maximum.size())));
  const auto escapes = std::partition_point(maximum.begin(), end, staysInside);
  if (escapes != maximum.begin())
    interval.lower = elementary::log(radialMaximum.step * static_cast<double>(escapes - maximum.begin()));
  return interval;
}

}  // namespace julia
