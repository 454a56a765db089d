// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/plot.h"

#include "support/limits.h"
#include "support/test_images.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <stdexcept>
#include <string>

namespace {

using test_images::kRed;
using test_images::kWhite;
using test_limits::kInfinity;
using test_limits::kNan;
using vdbtools::Colour;
using vdbtools::encodePlot;
using vdbtools::Image;
using vdbtools::Plot;
using vdbtools::PlotBand;
using vdbtools::plotImage;
using vdbtools::PlotSeries;

constexpr Colour kBlue{0, 0, 1};

struct Spot {
  double x = 0, y = 0;  ///< the mean of its pixels
  int count = 0;
  std::set<int> columns, rows;
};

/// The pixels whose hue is this colour's: red or blue, mixed with at most half of white or grey.
Spot spotOf(const Image& image, const Colour& colour) {
  const std::size_t strong = colour[0] > colour[2] ? 0 : 2;
  Spot spot;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Colour& pixel = image.at(x, y);
      if (pixel[strong] < 0.5F || pixel[2 - strong] > 0.3F || pixel[1] > 0.3F) continue;
      spot.x += x + 0.5;
      spot.y += y + 0.5;
      ++spot.count;
      spot.columns.insert(x);
      spot.rows.insert(y);
    }
  spot.x /= std::max(1, spot.count);
  spot.y /= std::max(1, spot.count);
  return spot;
}

Spot dotOf(const Plot& plot, double x, double y) {
  Plot with = plot;
  with.series.push_back({"", {{x, y}}, kRed});
  return spotOf(plotImage(with), kRed);
}

/// The pixels that differ between two plots.
Spot difference(const Plot& one, const Plot& other) {
  const Image a = plotImage(one), b = plotImage(other);
  Spot spot;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      if (a.at(x, y) == b.at(x, y)) continue;
      ++spot.count;
      spot.columns.insert(x);
      spot.rows.insert(y);
    }
  return spot;
}

TEST(Plot, PointsLieWhereTheDataSay) {
  for (const bool logY : {false, true}) {
    const Plot plot{.series = {{"", {{-2, 0.01}, {6, 100}}, kBlue}}, .logY = logY};
    const auto height = [&](double y) { return logY ? std::log10(y) : y; };
    const Spot low = dotOf(plot, -2, 0.01), high = dotOf(plot, 6, 100);
    ASSERT_GT(low.count, 0);
    for (const auto& [x, y] : {std::pair{0.0, 25.0}, {3.5, 0.5}, {5.9, 1.0}, {-1.0, 99.0}}) {
      const Spot dot = dotOf(plot, x, y);
      const double across = (x + 2) / 8, up = (height(y) - height(0.01)) / (height(100) - height(0.01));
      EXPECT_NEAR(dot.x, std::lerp(low.x, high.x, across), 1) << logY << ' ' << x;
      EXPECT_NEAR(dot.y, std::lerp(low.y, high.y, up), 1) << logY << ' ' << y;
    }
    EXPECT_GT(high.x - low.x, 700);  // of 900
    EXPECT_GT(low.y - high.y, 400);  // of 600
  }
}

TEST(Plot, CurvesAreDrawnFromPointToPoint) {
  const Plot plot{.series = {{"", {{0, 0}, {1, 1}}, kBlue}, {"", {{0, 1}, {1, 0}}, kRed}}, .width = 500, .height = 400};
  const Image image = plotImage(plot);
  EXPECT_EQ(image.width, 500);
  EXPECT_EQ(image.height, 400);
  EXPECT_EQ(image.at(0, 0), kWhite);
  for (const Colour& colour : {kRed, kBlue}) {
    const Spot curve = spotOf(image, colour);
    const int across = *curve.columns.rbegin() - *curve.columns.begin();
    EXPECT_GT(across, 350);
    EXPECT_GE(static_cast<int>(curve.columns.size()), across - 3);  // the other curve crosses it
    EXPECT_GT(curve.rows.size(), 250u);
  }
}

TEST(Plot, ALogarithmLeavesGapsOnly) {
  Plot plot{.series = {{"", {}, kRed}}, .logY = true};
  for (int n = 0; n <= 100; ++n)
    plot.series[0].points.emplace_back(n, n > 40 && n < 60 ? 0.0 : std::pow(10.0, n / 25.0 - 2));
  const std::set<int> columns = spotOf(plotImage(plot), kRed).columns;
  int widest = 0;
  for (auto column = columns.begin(); std::next(column) != columns.end(); ++column)
    widest = std::max(widest, *std::next(column) - *column);
  const int across = *columns.rbegin() - *columns.begin();
  EXPECT_NEAR(widest, 0.2 * across, 0.03 * across);
  EXPECT_NEAR(static_cast<double>(columns.size()), 0.8 * across, 0.05 * across);
}

TEST(Plot, PointsThatAreNotFiniteAreGaps) {
  const Image image =
      plotImage({.series = {{"", {{0, 0}, {1, 1}, {2, kNan}, {3, 1}, {4, 0}, {kNan, 0}, {5, kInfinity}}, kRed}}});
  const std::set<int> columns = spotOf(image, kRed).columns;
  const int middle = (*columns.begin() + *columns.rbegin()) / 2;
  EXPECT_EQ(columns.count(middle), 0u);
  EXPECT_EQ(columns.count(middle / 2 + *columns.begin() / 2), 1u);
}

TEST(Plot, ABandFillsItsRangeAndWidensNothing) {
  const auto rows = [](const PlotBand& band) {
    return static_cast<double>(
        spotOf(plotImage({.series = {{"", {{0, 0}, {1, 1}}, kRed}}, .band = band}), kBlue).rows.size());
  };
  const double all = rows({"", -kInfinity, kInfinity, kBlue});
  EXPECT_GT(all, 300);
  EXPECT_NEAR(rows({"", 0.5, 7, kBlue}), all / 2, 3);
  EXPECT_EQ(rows({"", 3, 7, kBlue}), 0);
  EXPECT_GT(rows({"named", 3, 7, kBlue}), 0) << "the legend shows its colour";
}

TEST(Plot, ASinglePointIsADot) {
  const Spot dot = spotOf(plotImage({.series = {{"", {{7, 3}}, kRed}}}), kRed);
  EXPECT_GT(dot.count, 0);
  EXPECT_LE(dot.columns.size(), 4u);
  EXPECT_LE(dot.rows.size(), 4u);
}

/// Each text changes pixels in its own place, and no others.
TEST(Plot, TextsStandInTheirPlaces) {
  const Plot plain{
      .series = {{"", {{0, 0}, {1, 1}}, kRed}}, .title = " ", .xLabel = " ", .yLabel = " ", .band = std::nullopt};
  const Spot axes = spotOf(plotImage(plain), kRed);
  const int left = *axes.columns.begin(), right = *axes.columns.rbegin(), top = *axes.rows.begin(),
            bottom = *axes.rows.rbegin();
  const auto centre = [](const std::set<int>& of) { return 0.5 * (*of.begin() + *of.rbegin()); };
  Plot with = plain;
  with.title = "The title";
  const Spot title = difference(plain, with);
  ASSERT_GT(title.count, 50);
  EXPECT_LT(*title.rows.rbegin(), top);
  EXPECT_NEAR(centre(title.columns), 0.5 * (left + right), 3);
  EXPECT_GT(*title.columns.rbegin() - *title.columns.begin(), 5 * (*title.rows.rbegin() - *title.rows.begin()) / 2);

  with = plain;
  with.xLabel = "along x";
  const Spot along = difference(plain, with);
  ASSERT_GT(along.count, 50);
  EXPECT_GT(*along.rows.begin(), bottom + 15);  // below the ticks' labels
  EXPECT_NEAR(centre(along.columns), 0.5 * (left + right), 3);

  with = plain;
  with.yLabel = "along y";
  const Spot upwards = difference(plain, with);
  ASSERT_GT(upwards.count, 50);
  EXPECT_LT(*upwards.columns.rbegin(), left - 15);
  EXPECT_NEAR(centre(upwards.rows), 0.5 * (top + bottom), 3);
  EXPECT_GT(upwards.rows.size(), 2 * upwards.columns.size());
}

TEST(Plot, TicksAreLabelledWhereTheDataAre) {
  const Plot plot{.series = {{"", {{0, -0.4}, {1, 0.4}}, kBlue}}};
  const Image image = plotImage(plot);
  const auto inkIn = [&](double x0, double x1, double y0, double y1) {
    int count = 0;
    for (int y = static_cast<int>(y0); y < static_cast<int>(y1); ++y)
      for (int x = static_cast<int>(x0); x < static_cast<int>(x1); ++x) count += image.at(x, y)[1] < 0.5F;
    return count;
  };
  for (const double tick : {-0.4, -0.2, 0.0, 0.2}) {
    const Spot dot = dotOf(plot, 0, tick);
    EXPECT_GT(inkIn(0, dot.x - 8, dot.y - 6, dot.y + 6), 30) << tick;
    EXPECT_EQ(inkIn(0, dot.x - 8, dot.y - 24, dot.y - 12), 0) << "between ticks, below " << tick;
  }
  // A negative number is longer by its sign.
  const Spot positive = dotOf(plot, 0, 0.2), negative = dotOf(plot, 0, -0.2);
  EXPECT_GT(inkIn(0, negative.x - 8, negative.y - 6, negative.y + 6),
            inkIn(0, positive.x - 8, positive.y - 6, positive.y + 6));
  for (const double tick : {0.0, 0.2, 0.8, 1.0}) {
    const Spot dot = dotOf(plot, tick, -0.4);
    EXPECT_GT(inkIn(dot.x - 12, dot.x + 12, dot.y + 8, dot.y + 24), 30) << tick;
  }
}

TEST(Plot, TheLegendHidesNoCurveIfItCan) {
  // Curves that leave one corner free: the legend goes there, and only its samples of lines are added.
  for (const bool atRight : {false, true})
    for (const bool atTop : {false, true}) {
      PlotSeries curve{"", {}, kRed};
      for (const auto& [x, y] : {std::pair{0, 0}, {0, 1}, {1, 1}, {1, 0}, {0, 0}})
        if ((x == 1) != atRight || (y == 1) != atTop) curve.points.emplace_back(x, y);
      Plot plot{.series = {curve}};
      const int bare = spotOf(plotImage(plot), kRed).count;
      plot.series[0].name = "a curve";
      EXPECT_GT(spotOf(plotImage(plot), kRed).count, bare) << atRight << atTop;
    }
}

// Promise: "A name that ends in `.svg` gives SVG"
TEST(Plot, SvgShowsTheSameAsPixels) {
  const Plot plot{.series = {{"curve", {{0, 0}, {0.25, 1}, {1, 0.5}}, kRed}}, .title = "Title"};
  const std::string svg = encodePlot(plot, ".svg");
  EXPECT_EQ(svg, encodePlot(plot, "svg"));
  EXPECT_NE(svg.find("width=\"900px\" height=\"600px\""), std::string::npos);
  // The curve's path goes through the dots of the picture.
  const std::size_t stroke = svg.find("stroke=\"#ff0000\"");
  ASSERT_NE(stroke, std::string::npos);
  const std::size_t path = svg.find("d=\"M ", stroke);
  double x[3], y[3];
  ASSERT_EQ(std::sscanf(svg.c_str() + path, "d=\"M %lf %lf L %lf %lf L %lf %lf", x, y, x + 1, y + 1, x + 2, y + 2), 6);
  Plot bare = plot;
  bare.series[0].colour = kBlue;
  bare.series[0].name = "";
  for (std::size_t i = 0; i < 3; ++i) {
    const Spot dot = dotOf(bare, plot.series[0].points[i].first, plot.series[0].points[i].second);
    EXPECT_NEAR(x[i], dot.x, 1);
    EXPECT_NEAR(y[i], dot.y, 1);
  }
  EXPECT_TRUE(encodePlot(plot, "PNG").starts_with("\x89PNG"));
  EXPECT_EQ(encodePlot(plot, "png"), vdbtools::encodeImage(plotImage(plot), "png"));
  EXPECT_THROW(encodePlot(plot, "pdf"), std::invalid_argument);
}

TEST(Plot, RangesOfAllSizes) {
  for (const double scale : {1e-300, 1e-12, 1.0, 1e12, 1e300})
    for (const double offset : {0.0, 1.0, -1e6})
      for (const bool logY : {false, true}) {
        const double y = scale * (1 + std::abs(offset));
        const Image image = plotImage({.series = {{"a", {{offset, y}, {offset + scale, 3 * y}}, kRed}}, .logY = logY});
        EXPECT_GT(spotOf(image, kRed).rows.size(), 100u) << scale << ' ' << offset << ' ' << logY;
      }
}

TEST(Plot, RefusesNothingToDraw) {
  const auto refused = [](const Plot& plot) { EXPECT_THROW(plotImage(plot), std::invalid_argument); };
  refused({});
  refused({.series = {{"empty", {}, kRed}}});
  refused({.series = {{"nothing", {{kNan, 1}}, kRed}}});
  refused({.series = {{"negative", {{1, -1}}, kRed}}, .logY = true});
  refused({.series = {{"small", {{1, 1}}, kRed}}, .width = 10});
  refused({.series = {{"band", {{1, 1}}, kRed}}, .logY = true, .band = PlotBand{}});
}

}  // namespace
