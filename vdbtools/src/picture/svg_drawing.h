// SPDX-License-Identifier: Apache-2.0
/// @file svg_drawing.h
/// Writes drawings as SVG 1.1. Cairo's SVG is not used, because it differs from release to release and numbers its
/// parts across the whole process. This SVG has no parts that need names.
#pragma once

#include "vdbtools/picture/canvas.h"

#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

class SvgDrawing {
 public:
  SvgDrawing(int width, int height);

  void fill(const CanvasBox& box, const Colour& colour, double opacity);
  void fill(std::span<const CanvasPoint> polygon, const Colour& colour, double opacity);
  /// @param points  not empty
  void line(std::span<const CanvasPoint> points, const LineStyle& style);

  /// @param utf8     the text for screen readers and for searches
  /// @param outline  commands of an SVG path in units of the font, y upwards, from the beginning of the baseline
  /// @param origin   where the baseline begins
  /// @param unit     pixels
  void text(std::string_view utf8, const std::string& outline, const CanvasPoint& origin, double unit,
            const TextStyle& style);

  /// @param png  the bytes of the file
  void image(std::string_view png, const CanvasBox& box);

  /// The bytes of the file.
  std::string bytes() const { return mText + "</svg>\n"; }

 private:
  void appendPoints(std::span<const CanvasPoint> points);

  std::string mText;
};

}  // namespace vdbtools
