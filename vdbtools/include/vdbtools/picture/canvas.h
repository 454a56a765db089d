// SPDX-License-Identifier: Apache-2.0
/// @file canvas.h
/// Draws lines, areas, text and images, on pixels with Cairo or as SVG.
///
/// Positions and lengths are in pixels from the top left corner, y downwards; integers lie on the edges of pixels.
/// Later drawing covers earlier drawing. Colours blend in sRGB, as they do in browsers.
///
/// Text is UTF-8 in DejaVu Sans, which is part of the library, so the fonts of a machine and the settings of Fontconfig
/// have no effect. A character that the font lacks is drawn as a box. In SVG, text consists of outlines, so it looks
/// the same on machines without the font; the attribute aria-label of each has its characters.
#pragma once

#include "vdbtools/picture/image.h"

#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

struct CanvasPoint {
  double x = 0, y = 0;
};

struct CanvasBox {
  double left = 0, top = 0, width = 0, height = 0;
};

struct LineStyle {
  Colour colour{};
  double width = 1;
};

/// The position of a text's anchor point along its baseline.
enum class TextAlign { Left, Centre, Right };

struct TextStyle {
  double size = 14;  ///< font size: the height of a line without leading
  TextAlign align = TextAlign::Left;
  bool bold = false;
  bool upwards = false;  ///< rotated by 90 degrees, so that it reads from bottom to top
  Colour colour{};
};

/// The height of capitals and digits, as a fraction of the font size.
inline constexpr double kCapHeight = 0.73;

enum class CanvasKind { Pixels, Svg };

/// Only one thread at a time may use it. The same calls give the same bytes.
class Canvas {
 public:
  /// @throw std::invalid_argument  a side that is not 1 to 32767 pixels
  Canvas(CanvasKind kind, int width, int height, const Colour& background = {1, 1, 1});
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  int width() const;
  int height() const;

  /// @param opacity  0 to 1
  void fill(const CanvasBox& box, const Colour& colour, double opacity = 1);
  /// Fills the polygon; the even-odd rule applies where it overlaps itself.
  void fill(std::span<const CanvasPoint> polygon, const Colour& colour, double opacity = 1);

  /// Draws the polyline with round corners and ends. A single point is a dot.
  void line(std::span<const CanvasPoint> points, const LineStyle& style);

  /// Draws one line of text, whose baseline runs through @a at.
  void text(std::string_view utf8, const CanvasPoint& at, const TextStyle& style);
  /// The length of that text along its baseline.
  double textWidth(std::string_view utf8, const TextStyle& style) const;

  /// Draws an image pixel for pixel, with its 8-bit sRGB codes.
  void image(const Image& image, int left, int top);

  /// Draws the image of a PNG pixel for pixel, with its codes.
  /// @param box  its position and size, integers
  /// @return false, and draws nothing, if the bytes are not a PNG of this size
  bool png(std::string_view bytes, const CanvasBox& box);

  /// Returns the drawing so far, in the 256 levels of sRGB. @throw std::logic_error  the canvas is SVG
  Image pixels() const;

  /// Ends the drawing and returns the bytes of its file. @param extension  png or exr for pixels, svg for SVG, with or
  /// without a dot
  /// @throw std::invalid_argument  another extension, or an extension of the other kind of canvas
  /// @throw IoError                Cairo or OpenImageIO failed, or a text was not UTF-8
  std::string encode(const std::string& extension);

 private:
  struct State;
  std::unique_ptr<State> mState;
};

/// The kind of canvas required for a file with this extension.
CanvasKind canvasKindOf(const std::string& extension);

}  // namespace vdbtools
