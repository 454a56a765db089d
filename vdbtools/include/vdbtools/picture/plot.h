// SPDX-License-Identifier: Apache-2.0
/// @file plot.h
/// Plots of curves, with round numbers on the axes and a legend. Text is UTF-8, in the font that canvas.h describes.
#pragma once

#include "vdbtools/picture/image.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

// Colours that colour-blind readers can distinguish (M. Okabe and K. Ito, "Color Universal Design", 2008).
inline constexpr Colour kVermilion{0.665F, 0.112F, 0}, kBlue{0, 0.168F, 0.445F}, kGreen{0, 0.342F, 0.171F};

struct PlotSeries {
  std::string name;                               ///< in the legend; a series without a name is not listed there
  std::vector<std::pair<double, double>> points;  ///< in order; a point that cannot be drawn leaves a gap
  Colour colour{};
};

/// A range of y that is shaded behind the curves. It does not widen the axes, and its ends may be infinite.
struct PlotBand {
  std::string name;  ///< in the legend
  double low = 0, high = 0;
  Colour colour{};
};

/// The axes cover every drawable point: both numbers must be finite (below 1e307), and y positive if its axis is
/// logarithmic.
struct Plot {
  std::vector<PlotSeries> series;
  std::string title, xLabel, yLabel;
  bool logY = false;             ///< decades on the y axis
  std::optional<PlotBand> band;  ///< only with a linear y axis
  int width = 900;               ///< pixels, 200 to 4096
  int height = 600;              ///< pixels, 150 to 4096
};

/// @throw std::invalid_argument  no drawable point, a size out of its range, or a band with a logarithmic axis
Image plotImage(const Plot& plot);

/// Encodes the plot as the bytes of a file. @param extension  png, exr or svg, with or without a dot
/// @throw std::invalid_argument  as plotImage(), or another extension
/// @throw IoError                the libraries cannot draw or encode it
std::string encodePlot(const Plot& plot, const std::string& extension);

}  // namespace vdbtools
