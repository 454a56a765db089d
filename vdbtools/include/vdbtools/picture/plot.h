// SPDX-License-Identifier: Apache-2.0
/// @file plot.h
/// Curves in a picture: axes with round numbers, a legend, and lettering of its own.
#pragma once

#include "vdbtools/picture/image.h"

#include <array>
#include <optional>
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

/// A range of y, behind the curves. The axes do not widen for it, and so its ends may be infinite.
struct PlotBand {
  std::string name;  ///< in the legend
  double low = 0, high = 0;
  std::array<float, 3> colour{};  ///< linear RGB
};

struct PlotOptions {
  std::string title, xLabel, yLabel;  ///< ASCII; what the lettering lacks is drawn as a box
  bool logY = false;                  ///< decades; values of 0 and below leave gaps
  int width = 900, height = 600;      ///< pixels, >= 200 and >= 150, <= 4096
  std::optional<PlotBand> band;       ///< of a linear y
};

/// The axes hold every point of every series that can be drawn: whose numbers are finite (below 1e307) and, for a
/// logarithm, positive.
/// @throw std::invalid_argument  no series, a picture too small or large, no point that can be drawn,
///                               or a band beside logY
Image plotLines(std::span<const PlotSeries> series, const PlotOptions& options);

}  // namespace vdbtools
