// SPDX-License-Identifier: Apache-2.0
#include "picture/svg_drawing.h"

#include "base/base64.h"
#include "base/srgb.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/recipe/option_value.h"

#include <array>
#include <charconv>

namespace vdbtools {
namespace {

/// A length in pixels, to a thousandth.
std::string pixelsText(double value) {
  constexpr int kDigits = 3;
  std::array<char, 400> buffer;  // the largest double has 309 digits
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, kDigits).ptr;
  std::string text(buffer.data(), end);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string attribute(std::string_view name, std::string_view value) {
  return std::string(" ").append(name).append("=\"").append(value).append("\"");
}

std::string attribute(std::string_view name, const Colour& colour) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = "#";
  for (const float channel : colour) {
    const auto code = srgbCode(channel);
    text += kDigits[code >> 4];
    text += kDigits[code & 15];
  }
  return attribute(name, text);
}

std::string fillOf(const Colour& colour, double opacity) {
  std::string text = attribute("fill", colour);
  if (opacity < 1) text += attribute("fill-opacity", numbersText({opacity}));
  return text;
}

std::string placeOf(const CanvasBox& box) {
  return attribute("x", pixelsText(box.left)) + attribute("y", pixelsText(box.top)) +
         attribute("width", pixelsText(box.width)) + attribute("height", pixelsText(box.height));
}

/// The text as the value of an attribute of XML, which cannot have control characters.
std::string escaped(std::string_view utf8) {
  std::string text;
  for (const char c : utf8) {
    if (c == '&')
      text += "&amp;";
    else if (c == '<')
      text += "&lt;";
    else if (c == '"')
      text += "&quot;";
    else
      text += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return text;
}

}  // namespace

SvgDrawing::SvgDrawing(int width, int height) {
  const std::string across = std::to_string(width), down = std::to_string(height);
  mText = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg" + attribute("xmlns", "http://www.w3.org/2000/svg") +
          attribute("xmlns:xlink", "http://www.w3.org/1999/xlink") + attribute("width", across + "px") +
          attribute("height", down + "px") + attribute("viewBox", "0 0 " + across + " " + down) +
          attribute("stroke-linecap", "round") + attribute("stroke-linejoin", "round") + ">\n";
}

void SvgDrawing::appendPoints(std::span<const CanvasPoint> points) {
  char command = 'M';
  for (const CanvasPoint& point : points) {
    if (command != 'M') mText += ' ';
    mText += command;
    mText += ' ' + pixelsText(point.x) + ' ' + pixelsText(point.y);
    command = 'L';
  }
}

void SvgDrawing::fill(const CanvasBox& box, const Colour& colour, double opacity) {
  mText += "<rect" + placeOf(box) + fillOf(colour, opacity) + "/>\n";
}

void SvgDrawing::fill(std::span<const CanvasPoint> polygon, const Colour& colour, double opacity) {
  mText += "<path" + fillOf(colour, opacity) + attribute("fill-rule", "evenodd") + " d=\"";
  appendPoints(polygon);
  mText += " Z\"/>\n";
}

void SvgDrawing::line(std::span<const CanvasPoint> points, const LineStyle& style) {
  mText += "<path" + attribute("fill", "none") + attribute("stroke", style.colour) +
           attribute("stroke-width", pixelsText(style.width)) + " d=\"";
  appendPoints(points);
  if (points.size() == 1) mText += " Z";  // a path of length 0 consists of its round ends
  mText += "\"/>\n";
}

void SvgDrawing::text(std::string_view utf8, const std::string& outline, const CanvasPoint& origin, double unit,
                      const TextStyle& style) {
  const std::string scale = numbersText({unit});
  const std::string axes = style.upwards ? "0 -" + scale + " -" + scale + " 0" : scale + " 0 0 -" + scale;
  mText += "<path" + attribute("aria-label", escaped(utf8)) + attribute("fill", style.colour) +
           attribute("transform", "matrix(" + axes + " " + pixelsText(origin.x) + " " + pixelsText(origin.y) + ")") +
           attribute("d", outline) + "/>\n";
}

void SvgDrawing::image(std::string_view png, const CanvasBox& box) {
  mText += "<image" + placeOf(box) + attribute("style", "image-rendering:pixelated") +
           attribute("xlink:href", "data:image/png;base64," + base64(png)) + "/>\n";
}

CanvasKind canvasKindOf(const std::string& extension) {
  const std::string name = lowerCase(extension);
  return name == "svg" || name == ".svg" ? CanvasKind::Svg : CanvasKind::Pixels;
}

}  // namespace vdbtools
