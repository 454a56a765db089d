// SPDX-License-Identifier: Apache-2.0
/// @file plot_axis.h
/// Axes of plots: their ranges, ticks and labels.
#pragma once

#include <string>
#include <vector>

namespace vdbtools {

struct PlotTick {
  double value = 0;   ///< in the axis's coordinate
  std::string label;  ///< empty for a minor tick
};

/// Maps a coordinate to pixels: the value itself or, on a logarithmic axis, its decimal logarithm.
struct PlotAxis {
  double low = 0, high = 1;
  double first = 0, last = 1;  ///< the pixels of low and high
  std::vector<PlotTick> ticks;

  double pixel(double value) const { return first + (value - low) / (high - low) * (last - first); }
};

/// Adds ticks at multiples of 1, 2 or 5 times a power of ten.
/// @param spacing  minimum distance between ticks, in pixels
/// @param widen    moves the ends of the axis outwards to the next ticks
void addLinearTicks(PlotAxis& axis, double spacing, bool widen);

/// Moves the ends of the axis outwards to powers of ten or, if the range is short, to 1, 2 or 5 times a power, and
/// labels these. @param spacing  minimum distance between labels of decades, in pixels
void addLogarithmicTicks(PlotAxis& axis, double spacing);

}  // namespace vdbtools
