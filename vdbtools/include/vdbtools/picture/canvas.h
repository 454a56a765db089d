// SPDX-License-Identifier: Apache-2.0
/// @file canvas.h
/// Draws lines, areas, text and images with Cairo, on pixels or as SVG.
///
/// Positions and lengths are pixels from the top left corner, y downwards; the whole numbers lie on the edges of
/// pixels. What is drawn later covers what was drawn before. Colours blend in sRGB, as they do in browsers.
///
/// Text is UTF-8 in DejaVu Sans, which is part of the library: the fonts of a machine and the settings of Fontconfig
/// change nothing. A character that the font lacks is a box. In SVG, text consists of outlines: it looks the same on
/// machines without the font.
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

/// Where the point that places a text lies along the text's baseline.
enum class TextAlign { Left, Centre, Right };

struct TextStyle {
  double size = 14;  ///< of the font: the height of a line without leading
  TextAlign align = TextAlign::Left;
  bool bold = false;
  bool upwards = false;  ///< turned by 90 degrees: reads from bottom to top
  Colour colour{};
};

/// The height of capitals and digits, as a part of the font's size.
inline constexpr double kCapHeight = 0.73;

enum class CanvasKind { Pixels, Svg };

/// For one thread at a time. The same calls give the same bytes.
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
  /// Fills the polygon; where it overlaps itself, by the even-odd rule.
  void fill(std::span<const CanvasPoint> polygon, const Colour& colour, double opacity = 1);

  /// Draws the polyline with round corners and ends. A single point is a dot.
  void line(std::span<const CanvasPoint> points, const LineStyle& style);

  /// Draws one line of text, the baseline of which runs through @a at.
  void text(std::string_view utf8, const CanvasPoint& at, const TextStyle& style);
  /// The length of the same text along its baseline.
  double textWidth(std::string_view utf8, const TextStyle& style) const;

  /// Puts an image there, pixel for pixel, with its 8-bit sRGB codes.
  void image(const Image& image, int left, int top);

  /// Puts the image of a PNG there, pixel for pixel, with its codes.
  /// @param box  its place and size, whole pixels
  /// @return false, and nothing is drawn, if the bytes are no PNG of this size
  bool png(std::string_view bytes, const CanvasBox& box);

  /// What was drawn so far, in the 256 levels of sRGB. @throw std::logic_error  the canvas is SVG
  Image pixels() const;

  /// Ends the drawing and returns the bytes of its file. @param extension  png or exr of pixels, svg of SVG, with or
  /// without a dot
  /// @throw std::invalid_argument  another extension, or one of the other kind
  /// @throw IoError                Cairo or OpenImageIO failed
  std::string encode(const std::string& extension);

 private:
  struct State;
  std::unique_ptr<State> mState;
};

/// The kind of canvas that a file with this extension needs.
CanvasKind canvasKindOf(const std::string& extension);

}  // namespace vdbtools
