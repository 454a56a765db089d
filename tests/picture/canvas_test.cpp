// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/canvas.h"

#include "support/test_images.h"
#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <regex>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace vdbtools;
using test_images::kBlack;
using test_images::kRed;
using test_images::kWhite;

/// The smallest box around what is not white, in whole pixels: left, top, right and bottom, the last two exclusive.
struct Ink {
  int left = 1 << 20, top = 1 << 20, right = 0, bottom = 0;
  double darkness = 0;  ///< summed, in pixels of black

  int width() const { return std::max(0, right - left); }
  int height() const { return std::max(0, bottom - top); }
};

Ink inkOf(const Image& image) {
  Ink ink;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y) == kWhite) continue;
      ink.left = std::min(ink.left, x);
      ink.top = std::min(ink.top, y);
      ink.right = std::max(ink.right, x + 1);
      ink.bottom = std::max(ink.bottom, y + 1);
      ink.darkness += 1 - image.at(x, y)[1];
    }
  return ink;
}

/// How much of a pixel black ink covers: what sRGB mixes.
double coverage(const Colour& pixel) {
  return 1 - (pixel[1] <= 0.0031308F ? 12.92F * pixel[1] : 1.055F * std::pow(pixel[1], 1 / 2.4F) - 0.055F);
}

Canvas pixels(int width = 200, int height = 100) { return {CanvasKind::Pixels, width, height}; }

Ink inkOfText(const std::string& text, const CanvasPoint& at, const TextStyle& style) {
  Canvas canvas = pixels(400, 400);
  canvas.text(text, at, style);
  return inkOf(canvas.pixels());
}

TEST(Canvas, FillsExactlyThePixelsOfABox) {
  Canvas canvas = pixels();
  canvas.fill({10, 20, 30, 5}, kRed);
  const Image image = canvas.pixels();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      EXPECT_EQ(image.at(x, y), x >= 10 && x < 40 && y >= 20 && y < 25 ? kRed : kWhite) << x << ' ' << y;
}

TEST(Canvas, OpacityMixesInSrgb) {
  Canvas canvas = pixels();
  canvas.fill({0, 0, 200, 100}, kBlack, 0.5);
  // Half of sRGB's 255 is the linear 0.2140 for 127.5.
  EXPECT_NEAR(canvas.pixels().at(50, 50)[1], 0.214F, 0.004F);
}

TEST(Canvas, PolygonsCoverTheirArea) {
  Canvas canvas = pixels();
  const CanvasPoint triangle[] = {{10, 10}, {110, 10}, {10, 90}};
  canvas.fill(triangle, kBlack);
  const Image image = canvas.pixels();
  double area = 0;
  for (const Colour& pixel : image.pixels) area += coverage(pixel);
  EXPECT_NEAR(area, 4000, 20);
  EXPECT_EQ(image.at(20, 20), kBlack);
  EXPECT_EQ(image.at(100, 80), kWhite);
}

TEST(Canvas, LinesLieWhereTheirPointsSay) {
  Canvas canvas = pixels();
  const CanvasPoint points[] = {{20, 30.5}, {120, 30.5}};
  canvas.line(points, {kBlack, 1});
  Ink ink = inkOf(canvas.pixels());
  EXPECT_EQ(ink.top, 30);
  EXPECT_EQ(ink.bottom, 31);
  EXPECT_NEAR(ink.left, 20, 1);
  EXPECT_NEAR(ink.right, 120, 1);

  Canvas dot = pixels();
  const CanvasPoint one[] = {{50, 60}};
  dot.line(one, {kBlack, 6});
  ink = inkOf(dot.pixels());
  EXPECT_NEAR(ink.width(), 6, 1);
  EXPECT_NEAR(ink.height(), 6, 1);
  EXPECT_NEAR(0.5 * (ink.left + ink.right), 50, 0.5);
  EXPECT_NEAR(0.5 * (ink.top + ink.bottom), 60, 0.5);
  dot.line({}, {kBlack, 6});  // nothing
  EXPECT_EQ(inkOf(dot.pixels()).darkness, ink.darkness);
}

TEST(Canvas, TextStandsOnItsBaseline) {
  const TextStyle style{.size = 40};
  const Ink capital = inkOfText("H", {100, 200}, style), hanging = inkOfText("Hp", {100, 200}, style);
  EXPECT_EQ(capital.bottom, 200);
  EXPECT_NEAR(capital.height(), kCapHeight * 40, 2.5);
  EXPECT_GE(capital.left, 100);
  EXPECT_LT(capital.right, 140);
  EXPECT_GT(hanging.bottom, 205);
  EXPECT_GT(hanging.right, capital.right);
  EXPECT_EQ(inkOfText("", {100, 200}, style).darkness, 0);
  EXPECT_GT(inkOfText("H", {100, 200}, {.size = 40, .bold = true}).darkness, 1.2 * capital.darkness);
}

TEST(Canvas, TextIsAlignedByItsWidth) {
  const std::string text = "Hamburg 123";
  TextStyle style{.size = 20};
  const double width = pixels().textWidth(text, style);
  const Ink left = inkOfText(text, {200, 100}, style);
  EXPECT_NEAR(left.width(), width, 5);
  style.align = TextAlign::Centre;
  EXPECT_NEAR(inkOfText(text, {200, 100}, style).left, left.left - width / 2, 1.5);
  style.align = TextAlign::Right;
  EXPECT_NEAR(inkOfText(text, {200, 100}, style).left, left.left - width, 1.5);
  EXPECT_NEAR(pixels().textWidth(text, {.size = 40}), 2 * width, 2);

  // Upwards: the same ink, turned.
  style.align = TextAlign::Left;
  style.upwards = true;
  const Ink upwards = inkOfText(text, {200, 300}, style);
  EXPECT_NEAR(upwards.height(), left.width(), 2);
  EXPECT_NEAR(upwards.width(), left.height(), 2);
  EXPECT_LE(upwards.bottom, 300);
  EXPECT_LE(upwards.left, 200);
  EXPECT_GT(upwards.right, 200);  // what hangs below the baseline
}

// Promise: "Text in pictures is set ..."
TEST(Canvas, TextIsUtf8) {
  // Characters of ASCII and beyond are single characters of different shapes.
  const TextStyle style{.size = 40};
  const Ink phi = inkOfText("\u03c6", {100, 200}, style), minus = inkOfText("\u2212", {100, 200}, style);
  EXPECT_GT(phi.height(), 2 * minus.height());
  EXPECT_LT(phi.width(), 40);
  EXPECT_GT(minus.darkness, 0);
}

// Promise: "Text in pictures is set ..."
TEST(Canvas, WhatTheFontLacksIsTheSameBox) {
  // No other font steps in.
  const TextStyle style{.size = 40};
  const auto bytes = [&](const std::string& text) {
    Canvas canvas = pixels(100, 60);
    canvas.text(text, {10, 45}, style);
    return canvas.encode("png");
  };
  EXPECT_EQ(bytes("\u4e2d"), bytes("\uac00"));
  EXPECT_GT(inkOfText("\u4e2d", {100, 200}, style).height(), 20);
  EXPECT_NE(bytes("\u4e2d"), bytes("\u03c6"));
}

TEST(Canvas, ThreadsMayDrawAtTheSameTime) {
  const auto draw = [](double size) {
    Canvas canvas = pixels(300, 100);
    for (const bool bold : {false, true})
      for (double y = 20; y < 90; y += 30) canvas.text("Voxels 0123 \u03c6", {5, y}, {.size = size, .bold = bold});
    return canvas.encode("png");
  };
  std::vector<std::string> alone, together(8);
  for (std::size_t i = 0; i < together.size(); ++i) alone.push_back(draw(10 + static_cast<double>(i)));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < together.size(); ++i)
    threads.emplace_back([&, i] { together[i] = draw(10 + static_cast<double>(i)); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(together, alone);
}

TEST(Canvas, ImagesKeepTheirCodes) {
  Image image(16, 16);
  for (int i = 0; i < 256; ++i) {
    const float v = static_cast<float>(i) / 255;
    image.pixels[static_cast<std::size_t>(i)] = {v, v * v, 1 - v};
  }
  Canvas canvas = pixels(40, 30);
  canvas.image(image, 7, 9);
  const Image drawn = canvas.pixels();
  Image part(16, 16);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) part.at(x, y) = drawn.at(x + 7, y + 9);
  EXPECT_EQ(encodeImage(part, "png"), encodeImage(image, "png"));
  EXPECT_EQ(drawn.at(6, 9), kWhite);
  EXPECT_EQ(drawn.at(23, 9), kWhite);
}

/// A drawing with everything in it.
std::string drawing(CanvasKind kind, const std::string& extension) {
  Canvas canvas(kind, 120, 80, {0.5F, 0.6F, 0.7F});
  const CanvasPoint points[] = {{12.5, 10}, {100, 60.25}};
  canvas.line(points, {kRed, 2});
  canvas.fill(points, kRed, 0.5);
  canvas.text("Text \u2212 1", {60, 40}, {.align = TextAlign::Centre});
  canvas.image(Image(8, 8), 3, 4);
  return canvas.encode(extension);
}

// Promise: "Text in pictures is set ..."
TEST(Canvas, TheSameDrawingHasTheSameBytes) {
  EXPECT_EQ(drawing(CanvasKind::Svg, "svg"), drawing(CanvasKind::Svg, ".SVG"));
  EXPECT_EQ(drawing(CanvasKind::Pixels, "png"), drawing(CanvasKind::Pixels, ".PNG"));
  EXPECT_EQ(drawing(CanvasKind::Pixels, "exr"), drawing(CanvasKind::Pixels, "exr"));
}

TEST(Canvas, SvgHoldsThePathsAndTheImage) {
  const std::string svg = drawing(CanvasKind::Svg, "svg");
  EXPECT_TRUE(svg.starts_with("<?xml"));
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  EXPECT_NE(svg.find("width=\"120px\" height=\"80px\" viewBox=\"0 0 120 80\""), std::string::npos);
  EXPECT_NE(svg.find("M 12.5 10 L 100 60.25"), std::string::npos);
  EXPECT_NE(svg.find("data:image/png;base64,iVBORw0KGgo"), std::string::npos);
  // Nothing has a name, which another drawing on the same page of HTML could have, too.
  EXPECT_EQ(svg.find(" id="), std::string::npos);
  EXPECT_EQ(svg.find("href=\"#"), std::string::npos);
}

// Promise: "A name that ends in `.svg` gives SVG"
TEST(Canvas, OutlinesInSvgCoverTheInkOfThePixels) {
  const std::regex form(
      "<path aria-label=\"([^\"]*)\" fill=\"#000000\" transform=\"matrix\\(([^)]*)\\)\" d=\"([^\"]*)\"/>");
  for (const bool upwards : {false, true})
    for (const bool bold : {false, true})
      for (const TextAlign align : {TextAlign::Left, TextAlign::Centre, TextAlign::Right}) {
        const TextStyle style{.size = 23.5, .align = align, .bold = bold, .upwards = upwards};
        const std::string text = "Hp \u2212 \u03c6 1";
        Canvas canvas(CanvasKind::Svg, 400, 400);
        canvas.text(text, {200.25, 199.5}, style);
        const std::string svg = canvas.encode("svg");
        std::smatch found;
        ASSERT_TRUE(std::regex_search(svg, found, form)) << svg;
        EXPECT_EQ(found[1], text);
        double matrix[6];
        std::istringstream numbers(found[2]);
        for (double& number : matrix) ASSERT_TRUE(numbers >> number);
        std::string path = found[3];
        for (char& c : path)
          if (std::isalpha(static_cast<unsigned char>(c))) c = ' ';
        std::istringstream points(path);
        double left = 1e9, top = 1e9, right = -1e9, bottom = -1e9;
        for (double x = 0, y = 0; points >> x >> y;) {
          const double across = matrix[0] * x + matrix[2] * y + matrix[4];
          const double down = matrix[1] * x + matrix[3] * y + matrix[5];
          left = std::min(left, across);
          right = std::max(right, across);
          top = std::min(top, down);
          bottom = std::max(bottom, down);
        }
        const Ink ink = inkOfText(text, {200.25, 199.5}, style);
        // Pixels have their letters on whole pixels, with heights to fit.
        EXPECT_NEAR(left, ink.left, 1.5);
        EXPECT_NEAR(right, ink.right, 1.5);
        EXPECT_NEAR(top, ink.top, 1.5);
        EXPECT_NEAR(bottom, ink.bottom, 1.5);
      }
}

TEST(Canvas, SvgHasAnyText) {
  Canvas canvas(CanvasKind::Svg, 100, 100);
  canvas.text("a<b> & \"c\"\n\u4e2d", {0, 50}, {});
  canvas.text("", {0, 50}, {});
  const std::string svg = canvas.encode("svg");
  EXPECT_NE(svg.find("aria-label=\"a&lt;b> &amp; &quot;c&quot; \u4e2d\""), std::string::npos) << svg;
  EXPECT_EQ(svg.find("aria-label=\"\""), std::string::npos);
  Canvas wrong(CanvasKind::Svg, 100, 100);
  wrong.text("\xff", {0, 50}, {});
  EXPECT_THROW(wrong.encode("svg"), IoError);
}

/// It covers of each pixel what its segments cover together, each with round ends: as much as the first of them, or
/// more, and nothing twice.
TEST(Canvas, ALineIsTheUnionOfItsSegments) {
  constexpr double kSamples = 0.08;  // Cairo takes 15 samples down a pixel
  for (const double width : {1.0, 2.2, 6.0}) {
    std::vector<CanvasPoint> points;
    for (int i = 0; i < 40; ++i) points.push_back({10 + 4.5 * i, 50 + 30 * std::sin(0.7 * i * i)});
    Canvas whole = pixels();
    whole.line(points, {kBlack, width});
    const Image image = whole.pixels();
    std::vector<double> most(image.pixels.size()), sum(image.pixels.size());
    for (std::size_t i = 1; i < points.size(); ++i) {
      Canvas part = pixels();
      part.line(std::span(points).subspan(i - 1, 2), {kBlack, width});
      const Image segment = part.pixels();
      for (std::size_t k = 0; k < most.size(); ++k) {
        most[k] = std::max(most[k], coverage(segment.pixels[k]));
        sum[k] += coverage(segment.pixels[k]);
      }
    }
    for (std::size_t k = 0; k < most.size(); ++k) {
      EXPECT_GE(coverage(image.pixels[k]), most[k] - kSamples);
      EXPECT_LE(coverage(image.pixels[k]), sum[k] + kSamples);
    }
  }
}

TEST(Canvas, RefusesWhatItCannotDraw) {
  EXPECT_THROW(Canvas(CanvasKind::Pixels, 0, 10), std::invalid_argument);
  EXPECT_THROW(Canvas(CanvasKind::Svg, 10, -1), std::invalid_argument);
  EXPECT_THROW(Canvas(CanvasKind::Pixels, 40000, 10), std::invalid_argument);
  EXPECT_THROW(pixels().encode("svg"), std::invalid_argument);
  EXPECT_THROW(pixels().encode("jpg"), std::invalid_argument);
  EXPECT_THROW(Canvas(CanvasKind::Svg, 10, 10).encode("png"), std::invalid_argument);
  EXPECT_THROW(Canvas(CanvasKind::Svg, 10, 10).pixels(), std::logic_error);
}

}  // namespace
