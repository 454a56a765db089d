// SPDX-License-Identifier: Apache-2.0
/// @file plot.h
/// Curves in a picture: axes with round numbers, a legend, and lettering of its own.
#pragma once

#include "vdbtools/image.h"

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

struct PlotSeries {
  std::string name;                               ///< in the legend, which an empty one stays out of
  std::vector<std::pair<double, double>> points;  ///< in order; a point that cannot be drawn leaves a gap
  std::array<float, 3> colour{};                  ///< linear RGB
};

struct PlotOptions {
  std::string title, xLabel, yLabel;  ///< ASCII; what the lettering lacks is drawn as a box
  bool logY = false;                  ///< decades; values of 0 and below leave gaps
  int width = 900, height = 600;      ///< pixels, >= 200 and >= 150, <= 4096
};

/// The axes hold every point of every series that can be drawn: whose numbers are finite (below 1e307) and, for a
/// logarithm, positive.
/// @throw std::invalid_argument  no series, a picture too small or large, or no point that can be drawn
Image plotLines(std::span<const PlotSeries> series, const PlotOptions& options);

}  // namespace vdbtools
