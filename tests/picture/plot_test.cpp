// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

using namespace vdbtools;

namespace {

using Colour = std::array<float, 3>;
constexpr Colour kRed{1, 0, 0}, kBlue{0, 0, 1};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

/// Columns that hold a pixel of exactly this colour.
std::set<int> columnsOf(const Image& image, const Colour& colour) {
  std::set<int> columns;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (image.at(x, y) == colour) columns.insert(x);
  return columns;
}

int rowsOf(const Image& image, const Colour& colour) {
  int rows = 0;
  for (int y = 0; y < image.height; ++y) {
    int x = 0;
    while (x < image.width && image.at(x, y) != colour) ++x;
    rows += x < image.width;
  }
  return rows;
}

Image plot(const std::vector<PlotSeries>& series, const PlotOptions& options = {}) {
  return plotLines(series, options);
}

TEST(Plot, SizeAndColours) {
  const Image image = plot({{"falling", {{0, 1}, {1, 0}}, kRed}, {"rising", {{0, 0}, {1, 1}}, kBlue}},
                           {.title = "Two lines", .xLabel = "x", .yLabel = "y", .width = 500, .height = 400});
  EXPECT_EQ(image.width, 500);
  EXPECT_EQ(image.height, 400);
  EXPECT_EQ(image.at(0, 0), (Colour{1, 1, 1}));
  EXPECT_GT(columnsOf(image, kRed).size(), 300u);
  EXPECT_GT(columnsOf(image, kBlue).size(), 300u);
  EXPECT_GT(rowsOf(image, kRed), 200);
}

TEST(Plot, LogarithmLeavesGapsOnly) {
  std::vector<std::pair<double, double>> points;
  for (int n = 0; n <= 100; ++n) points.emplace_back(n, n > 40 && n < 60 ? 0.0 : std::pow(10.0, n / 25.0 - 2));
  const Image image = plot({{"", points, kRed}}, {.logY = true});
  const std::set<int> columns = columnsOf(image, kRed);
  int widest = 0;
  for (auto column = columns.begin(); std::next(column) != columns.end(); ++column)
    widest = std::max(widest, *std::next(column) - *column);
  const int across = *columns.rbegin() - *columns.begin();
  EXPECT_NEAR(widest, 0.2 * across, 0.03 * across);
  EXPECT_NEAR(static_cast<double>(columns.size()), 0.8 * across, 0.05 * across);
}

TEST(Plot, PointsThatAreNotFiniteAreGaps) {
  const Image image = plot({{"", {{0, 0}, {1, 1}, {2, kNaN}, {3, 1}, {4, 0}, {kNaN, 0}}, kRed}});
  const std::set<int> columns = columnsOf(image, kRed);
  const int middle = (*columns.begin() + *columns.rbegin()) / 2;
  EXPECT_EQ(columns.count(middle), 0u);
  EXPECT_EQ(columns.count(middle / 2 + *columns.begin() / 2), 1u);
}

TEST(Plot, BandFillsItsRangeAndWidensNothing) {
  const std::vector<PlotSeries> series{{"", {{0, 0}, {1, 1}}, kRed}};
  const int all = rowsOf(plot(series, {.band = PlotBand{"", -kInfinity, kInfinity, kBlue}}), kBlue);
  const int half = rowsOf(plot(series, {.band = PlotBand{"", 0.5, 7, kBlue}}), kBlue);
  EXPECT_GT(all, 300);
  EXPECT_NEAR(half, all / 2.0, 2);
  EXPECT_EQ(rowsOf(plot(series, {.band = PlotBand{"", 3, 7, kBlue}}), kBlue), 0);
  EXPECT_GT(rowsOf(plot(series, {.band = PlotBand{"named", 3, 7, kBlue}}), kBlue), 0);
  EXPECT_THROW(plot(series, {.logY = true, .band = PlotBand{}}), std::invalid_argument);
}

TEST(Plot, OnePointIsADot) {
  const Image image = plot({{"", {{7, 3}}, kRed}});
  EXPECT_FALSE(columnsOf(image, kRed).empty());
  EXPECT_LE(columnsOf(image, kRed).size(), 3u);
}

TEST(Plot, RangesOfAllSizes) {
  for (const double scale : {1e-300, 1e-12, 1.0, 1e12, 1e300})
    for (const double offset : {0.0, 1.0, -1e6})
      for (const bool logY : {false, true}) {
        const double y = scale * (1 + std::abs(offset));
        const Image image = plot({{"a", {{offset, y}, {offset + scale, 3 * y}}, kRed}}, {.logY = logY});
        EXPECT_FALSE(columnsOf(image, kRed).empty()) << scale << ' ' << offset << ' ' << logY;
      }
}

TEST(Plot, RefusesNothing) {
  EXPECT_THROW(plot({}), std::invalid_argument);
  EXPECT_THROW(plot({{"empty", {}, kRed}}), std::invalid_argument);
  EXPECT_THROW(plot({{"nothing", {{kNaN, 1}}, kRed}}), std::invalid_argument);
  EXPECT_THROW(plot({{"negative", {{1, -1}}, kRed}}, {.logY = true}), std::invalid_argument);
  EXPECT_THROW(plot({{"small", {{1, 1}}, kRed}}, {.width = 10}), std::invalid_argument);
}

}  // namespace
