// SPDX-License-Identifier: Apache-2.0
#include "picture/plot_axis.h"

#include "base/elementary.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace vdbtools {
namespace {

constexpr double kRounding = 1e-6;  ///< relative to a step between ticks

/// A true minus sign instead of the hyphen.
std::string withMinus(std::string number) {
  for (std::size_t at = 0; (at = number.find('-', at)) != std::string::npos;) number.replace(at, 1, "\u2212");
  return number;
}

/// Like printf's %g, with the shortest exponent: 1e-5 instead of 1e-05, 1e6 instead of 1e+06.
std::string generalText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  std::string result = text;
  const std::size_t e = result.find('e');
  if (e == std::string::npos) return withMinus(result);
  std::size_t digits = e + 1;
  if (result[digits] == '+')
    result.erase(digits, 1);
  else
    ++digits;
  while (result[digits] == '0' && digits + 1 < result.size()) result.erase(digits, 1);
  return withMinus(result);
}

/// The text of a multiple of @a step, with as many decimals as the step needs, if that is readable.
std::string multipleText(double value, double step, double largest) {
  constexpr double kLongest = 1e6, kFinest = 1e-5;
  if (largest >= kLongest || step < kFinest) return generalText(value);
  const int decimals = std::max(0, -static_cast<int>(std::floor(elementary::log10(step) + kRounding)));
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return withMinus(text);
}

/// The smallest of 1, 2 and 5 times a power of ten that is not below @a step.
double roundStep(double step) {
  const double decade = elementary::pow(10.0, std::floor(elementary::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= step * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}

/// Widens a range of zero length, so that a single value lies in its middle.
void giveExtent(double& low, double& high) {
  const double least = 1e-9 * std::max(std::abs(low), std::abs(high));
  if (high - low > least) return;
  const double room = std::max(std::abs(low) / 10, low == 0 ? 1.0 : least);
  low -= room;
  high += room;
}

/// Possible ends of a logarithmic axis, from below @a low to above @a high.
std::vector<double> possibleEnds(double low, double high, bool fewDecades) {
  std::vector<double> ends;
  for (double decade = std::floor(low) - 1; decade <= std::ceil(high) + 1; ++decade)
    for (const int digit : {1, 2, 5})
      if (digit == 1 || fewDecades) ends.push_back(decade + elementary::log10(digit));
  return ends;
}

}  // namespace

void addLinearTicks(PlotAxis& axis, double spacing, bool widen) {
  giveExtent(axis.low, axis.high);
  const double length = std::abs(axis.last - axis.first);
  const double step = roundStep((axis.high - axis.low) * spacing / length);
  if (widen) {
    axis.low = std::floor(axis.low / step + kRounding) * step;
    axis.high = std::ceil(axis.high / step - kRounding) * step;
  }
  const double largest = std::max(std::abs(axis.low), std::abs(axis.high));
  const double first = std::ceil(axis.low / step - kRounding), last = std::floor(axis.high / step + kRounding);
  for (double n = first; n <= last; ++n) {
    const double value = n * step + 0.0;  // no -0
    axis.ticks.push_back({value, multipleText(value, step, largest)});
  }
}

void addLogarithmicTicks(PlotAxis& axis, double spacing) {
  giveExtent(axis.low, axis.high);
  constexpr double kFewDecades = 1.5;  // labels at decades alone would be too few
  const bool few = axis.high - axis.low < kFewDecades;
  const std::vector<double> ends = possibleEnds(axis.low, axis.high, few);
  const auto above = std::find_if(ends.begin(), ends.end(), [&](double end) { return end >= axis.high - kRounding; });
  const auto below = std::find_if(ends.rbegin(), ends.rend(), [&](double end) { return end <= axis.low + kRounding; });
  axis.low = *below;
  axis.high = *above;
  const double perDecade = std::abs(axis.last - axis.first) / (axis.high - axis.low);
  const int every = std::max(1, static_cast<int>(std::ceil(spacing / perDecade)));
  constexpr double kRoomForMinor = 40;  // pixels per decade
  const int lowest = static_cast<int>(std::floor(axis.low)), highest = static_cast<int>(std::ceil(axis.high));
  for (int decade = lowest; decade <= highest; ++decade)
    for (int digit = 1; digit < 10; ++digit) {
      const double value = decade + elementary::log10(digit);
      if (value < axis.low - kRounding || value > axis.high + kRounding) continue;
      const bool labelled = digit == 1 ? decade % every == 0 : few && (digit == 2 || digit == 5);
      if (!labelled && (digit == 1 ? every > 1 : perDecade < kRoomForMinor)) continue;
      axis.ticks.push_back({value, labelled ? generalText(digit * elementary::pow(10.0, decade)) : std::string()});
    }
}

}  // namespace vdbtools
