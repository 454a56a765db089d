// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/plot.h"

#include "picture/pixel_font.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace vdbtools {
namespace {

using Colour = std::array<float, 3>;

constexpr Colour kWhite{1, 1, 1}, kInk{0.02F, 0.02F, 0.02F}, kAxis{0.15F, 0.15F, 0.15F}, kGridLine{0.78F, 0.78F, 0.78F},
    kMinorGridLine{0.9F, 0.9F, 0.9F};

constexpr int kText = 2;                                 ///< pixels of the picture a pixel of the font
constexpr int kAdvance = (kGlyphWidth + 1) * kText;      ///< from a letter to the next
constexpr int kAscent = kGlyphAscent * kText;            ///< of capitals
constexpr int kLine = (kGlyphHeight + 3) * kText;        ///< from a line of text to the next
constexpr int kGap = 10;                                 ///< between things that shall not touch
constexpr double kLargest = 1e307;                       ///< so that differences of numbers are numbers
constexpr double kLineWidth = 2.2;                       ///< of a curve
constexpr double kTickSpacing = 90, kTickSpacingY = 55;  ///< between labelled ticks, about
constexpr int kKeyLength = 26;                           ///< of a curve's sample in the legend

int textWidth(std::string_view text) { return static_cast<int>(text.size()) * kAdvance - kText; }

void blend(Image& image, int x, int y, const Colour& colour, float coverage) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  for (std::size_t c = 0; c < 3; ++c) {
    float& value = image.at(x, y)[c];
    value += (colour[c] - value) * coverage;
  }
}

void fill(Image& image, int x0, int y0, int x1, int y1, const Colour& colour) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) blend(image, x, y, colour, 1);
}

/// The text's top left corner is (x, y); upright, its bottom left.
void drawText(Image& image, int x, int y, std::string_view text, bool upright = false) {
  for (const char character : text) {
    for (int row = 0; row < kGlyphHeight * kText; ++row)
      for (int column = 0; column < kGlyphWidth * kText; ++column)
        if (glyphInk(character, column / kText, row / kText))
          blend(image, upright ? x + row : x + column, upright ? y - column : y + row, kInk, 1);
    (upright ? y : x) += upright ? -kAdvance : kAdvance;
  }
}

struct Tick {
  double value = 0;   ///< of the axis, a logarithm's exponent
  std::string label;  ///< none: a minor one
};

/// A coordinate from its range to pixels.
struct Axis {
  double low = 0, high = 1;
  double first = 0, last = 1;  ///< pixels
  std::vector<Tick> ticks;

  double pixel(double value) const { return first + (value - low) / (high - low) * (last - first); }
};

/// As printf's %g, but never longer than it need be.
std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  std::string result = text;
  const std::size_t e = result.find('e');
  if (e == std::string::npos) return result;
  // 1e-05 is 1e-5, and 1e+06 is 1e6.
  std::size_t digits = e + 1;
  if (result[digits] == '+')
    result.erase(digits, 1);
  else
    ++digits;
  while (result[digits] == '0' && digits + 1 < result.size()) result.erase(digits, 1);
  return result;
}

/// 1, 2 or 5 times a power of ten, and no less than @a step.
double roundStep(double step) {
  const double decade = std::pow(10.0, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= step * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}

/// Widens a range without extent, so that a lone value stands in the middle.
void giveExtent(double& low, double& high) {
  const double least = 1e-9 * std::max(std::abs(low), std::abs(high));
  if (high - low > least) return;
  const double room = std::max(std::abs(low) / 10, low == 0 ? 1.0 : least);
  low -= room;
  high += room;
}

/// @param widen  to the next ticks
void makeLinear(Axis& axis, double spacing, bool widen) {
  giveExtent(axis.low, axis.high);
  const double length = std::abs(axis.last - axis.first);
  const double step = roundStep((axis.high - axis.low) * spacing / length);
  constexpr double kRounding = 1e-6;
  if (widen) {
    axis.low = std::floor(axis.low / step + kRounding) * step;
    axis.high = std::ceil(axis.high / step - kRounding) * step;
  }
  const double first = std::ceil(axis.low / step - kRounding), last = std::floor(axis.high / step + kRounding);
  for (double n = first; n <= last; ++n) axis.ticks.push_back({n * step, numberText(n * step + 0.0)});  // no -0
}

/// low and high come as exponents of ten.
void makeLogarithmic(Axis& axis, double spacing) {
  giveExtent(axis.low, axis.high);
  constexpr double kRounding = 1e-6;
  constexpr double kFewDecades = 1.5;  // below it, a decade's label or two would be too few
  const bool few = axis.high - axis.low < kFewDecades;
  std::vector<double> bounds;  // where the axis may end: within few decades at 1, 2 and 5
  const int lowest = static_cast<int>(std::floor(axis.low)) - 1, highest = static_cast<int>(std::ceil(axis.high)) + 1;
  for (int decade = lowest; decade <= highest; ++decade)
    for (const int digit : {1, 2, 5})
      if (digit == 1 || few) bounds.push_back(decade + std::log10(digit));
  const auto above = std::find_if(bounds.begin(), bounds.end(), [&](double b) { return b >= axis.high - kRounding; });
  const auto below = std::find_if(bounds.rbegin(), bounds.rend(), [&](double b) { return b <= axis.low + kRounding; });
  axis.low = *below;
  axis.high = *above;
  const double perDecade = std::abs(axis.last - axis.first) / (axis.high - axis.low);
  const int every = std::max(1, static_cast<int>(std::ceil(spacing / perDecade)));
  constexpr double kRoomForMinor = 40;  // pixels a decade
  for (int decade = lowest; decade <= highest; ++decade)
    for (int digit = 1; digit < 10; ++digit) {
      const double value = decade + std::log10(digit);
      if (value < axis.low - kRounding || value > axis.high + kRounding) continue;
      const bool labelled = digit == 1 ? decade % every == 0 : few && (digit == 2 || digit == 5);
      if (!labelled && (digit == 1 ? every > 1 : perDecade < kRoomForMinor)) continue;
      axis.ticks.push_back({value, labelled ? numberText(digit * std::pow(10.0, decade)) : std::string()});
    }
}

/// One point as the axes have it; none if it cannot be drawn.
std::optional<std::pair<double, double>> drawable(const std::pair<double, double>& point, bool logY) {
  const double y = logY ? (point.second > 0 ? std::log10(point.second) : NAN) : point.second;
  if (!(std::abs(point.first) < kLargest && std::abs(y) < kLargest)) return std::nullopt;
  return std::pair{point.first, y};
}

/// How much of each pixel a curve covers: pieces of one curve that overlap do not add up.
class Coverage {
 public:
  Coverage(int width, int height) : mWidth(width), mHeight(height) {
    mValues.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }

  void addSegment(double x0, double y0, double x1, double y1) {
    constexpr double kReach = kLineWidth / 2 + 1;
    const int left = std::max(0, static_cast<int>(std::floor(std::min(x0, x1) - kReach)));
    const int right = std::min(mWidth - 1, static_cast<int>(std::ceil(std::max(x0, x1) + kReach)));
    const int top = std::max(0, static_cast<int>(std::floor(std::min(y0, y1) - kReach)));
    const int bottom = std::min(mHeight - 1, static_cast<int>(std::ceil(std::max(y0, y1) + kReach)));
    const double dx = x1 - x0, dy = y1 - y0, squared = dx * dx + dy * dy;
    for (int y = top; y <= bottom; ++y)
      for (int x = left; x <= right; ++x) {
        const double px = x + 0.5 - x0, py = y + 0.5 - y0;
        const double t = squared > 0 ? std::clamp((px * dx + py * dy) / squared, 0.0, 1.0) : 0;
        const double distance = std::hypot(px - t * dx, py - t * dy);
        float& value = at(x, y);
        value = std::max(value, static_cast<float>(std::clamp(kLineWidth / 2 + 0.5 - distance, 0.0, 1.0)));
      }
  }

  float& at(int x, int y) { return mValues[static_cast<std::size_t>(y) * static_cast<std::size_t>(mWidth) + x]; }

  void blendInto(Image& image, const Colour& colour) {
    for (int y = 0; y < mHeight; ++y)
      for (int x = 0; x < mWidth; ++x)
        if (at(x, y) > 0) blend(image, x, y, colour, at(x, y));
  }

 private:
  int mWidth, mHeight;
  std::vector<float> mValues;
};

void drawCurve(Coverage& coverage, const PlotSeries& series, const Axis& x, const Axis& y, bool logY) {
  double fromX = 0, fromY = 0;
  bool joined = false;
  for (const auto& point : series.points) {
    const auto here = drawable(point, logY);
    if (here) {
      const double toX = x.pixel(here->first), toY = y.pixel(here->second);
      coverage.addSegment(joined ? fromX : toX, joined ? fromY : toY, toX, toY);  // after a gap, a dot
      fromX = toX;
      fromY = toY;
    }
    joined = here.has_value();
  }
}

int widestLabel(const Axis& axis) {
  int widest = 0;
  for (const Tick& tick : axis.ticks) widest = std::max(widest, textWidth(tick.label));
  return widest;
}

int pixelOf(double position) { return static_cast<int>(std::lround(position)); }

/// What of the band lies between the axes.
void drawBand(Image& image, const Axis& x, const Axis& y, const PlotBand& band) {
  const auto row = [&](double value) { return pixelOf(y.pixel(std::clamp(value, y.low, y.high))); };
  fill(image, pixelOf(x.first), row(band.high), pixelOf(x.last), row(band.low), band.colour);
}

void drawAxes(Image& image, const Axis& x, const Axis& y, const PlotOptions& options) {
  const int left = pixelOf(x.first), right = pixelOf(x.last), bottom = pixelOf(y.first), top = pixelOf(y.last);
  constexpr int kTick = 5;
  for (const bool minor : {true, false}) {
    const Colour& colour = minor ? kMinorGridLine : kGridLine;
    for (const Tick& tick : x.ticks)
      if (tick.label.empty() == minor)
        fill(image, pixelOf(x.pixel(tick.value)), top, pixelOf(x.pixel(tick.value)) + 1, bottom, colour);
    for (const Tick& tick : y.ticks)
      if (tick.label.empty() == minor)
        fill(image, left, pixelOf(y.pixel(tick.value)), right, pixelOf(y.pixel(tick.value)) + 1, colour);
  }
  fill(image, left, bottom, right + 1, bottom + 1, kAxis);
  fill(image, left, top, left + 1, bottom + 1, kAxis);
  for (const Tick& tick : x.ticks) {
    const int at = pixelOf(x.pixel(tick.value));
    fill(image, at, bottom, at + 1, bottom + kTick, kAxis);
    drawText(image, std::min(at - textWidth(tick.label) / 2, image.width - textWidth(tick.label) - 2),
             bottom + kTick + 4, tick.label);
  }
  for (const Tick& tick : y.ticks) {
    const int at = pixelOf(y.pixel(tick.value));
    fill(image, left - (tick.label.empty() ? kTick / 2 : kTick), at, left, at + 1, kAxis);
    drawText(image, left - kTick - 4 - textWidth(tick.label), at - kAscent / 2, tick.label);
  }
  drawText(image, (left + right - textWidth(options.title)) / 2, kGap, options.title);
  drawText(image, (left + right - textWidth(options.xLabel)) / 2, image.height - kLine, options.xLabel);
  drawText(image, kGap - 2, (top + bottom + textWidth(options.yLabel)) / 2, options.yLabel, true);
}

/// In the corner of the axes where it hides least of the curves.
void drawLegend(Image& image, const Axis& x, const Axis& y, std::span<const PlotSeries> series,
                const std::optional<PlotBand>& band, std::vector<Coverage>& curves) {
  int rows = 0, width = 0;
  const auto count = [&](const std::string& name) {
    if (name.empty()) return;
    ++rows;
    width = std::max(width, kKeyLength + kGap + textWidth(name));
  };
  for (const PlotSeries& one : series) count(one.name);
  if (band) count(band->name);
  if (rows == 0) return;
  width += 2 * kGap;
  const int height = rows * kLine + kGap;
  const int left = pixelOf(x.first) + kGap, right = pixelOf(x.last) - kGap - width;
  const int top = pixelOf(y.last) + kGap, bottom = pixelOf(y.first) - kGap - height;
  int bestX = right, bestY = top;
  double least = std::numeric_limits<double>::infinity();
  for (const int yAt : {top, bottom})
    for (const int xAt : {right, left}) {
      double hidden = 0;
      for (Coverage& curve : curves)
        for (int py = std::max(0, yAt); py < std::min(image.height, yAt + height); ++py)
          for (int px = std::max(0, xAt); px < std::min(image.width, xAt + width); ++px) hidden += curve.at(px, py);
      if (hidden >= least) continue;
      least = hidden;
      bestX = xAt;
      bestY = yAt;
    }
  fill(image, bestX, bestY, bestX + width, bestY + height, kGridLine);
  fill(image, bestX + 1, bestY + 1, bestX + width - 1, bestY + height - 1, kWhite);
  int row = bestY + kGap;
  for (const PlotSeries& one : series) {
    if (one.name.empty()) continue;
    Coverage key(image.width, image.height);
    const double middle = row + kAscent / 2.0;
    key.addSegment(bestX + kGap, middle, bestX + kGap + kKeyLength, middle);
    key.blendInto(image, one.colour);
    drawText(image, bestX + 2 * kGap + kKeyLength, row, one.name);
    row += kLine;
  }
  if (!band || band->name.empty()) return;
  fill(image, bestX + kGap, row, bestX + kGap + kKeyLength, row + kAscent, band->colour);
  drawText(image, bestX + 2 * kGap + kKeyLength, row, band->name);
}

void requireDrawable(std::span<const PlotSeries> series, const PlotOptions& options) {
  constexpr int kLeastWidth = 200, kLeastHeight = 150, kMost = 4096;
  if (options.width < kLeastWidth || options.height < kLeastHeight || options.width > kMost || options.height > kMost)
    throw std::invalid_argument("a plot of " + std::to_string(options.width) + " x " + std::to_string(options.height) +
                                " pixels cannot be drawn; use 200 x 150 to 4096 x 4096");
  if (options.band && options.logY) throw std::invalid_argument("a band has no place beside a logarithm");
  for (const PlotSeries& one : series)
    for (const auto& point : one.points)
      if (drawable(point, options.logY)) return;
  throw std::invalid_argument(std::string("there is nothing to plot: no series has a point that is finite") +
                              (options.logY ? " and above 0" : ""));
}

}  // namespace

Image plotLines(std::span<const PlotSeries> series, const PlotOptions& options) {
  requireDrawable(series, options);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Axis x, y;
  x.low = y.low = kInfinity;
  x.high = y.high = -kInfinity;
  for (const PlotSeries& one : series)
    for (const auto& point : one.points)
      if (const auto here = drawable(point, options.logY)) {
        x.low = std::min(x.low, here->first);
        x.high = std::max(x.high, here->first);
        y.low = std::min(y.low, here->second);
        y.high = std::max(y.high, here->second);
      }

  const int below = (options.xLabel.empty() ? 1 : 2) * kLine + kGap;
  y.first = options.height - below;
  y.last = options.title.empty() ? 2 * kGap : kGap + kLine + kGap / 2.0;
  if (options.logY)
    makeLogarithmic(y, kTickSpacingY);
  else
    makeLinear(y, kTickSpacingY, true);
  x.first = (options.yLabel.empty() ? 0 : kLine) + widestLabel(y) + 2 * kGap;
  x.last = options.width - 2 * kGap - 1;
  makeLinear(x, kTickSpacing, false);

  Image image(options.width, options.height);
  std::fill(image.pixels.begin(), image.pixels.end(), kWhite);
  if (options.band) drawBand(image, x, y, *options.band);
  drawAxes(image, x, y, options);
  std::vector<Coverage> curves;
  for (const PlotSeries& one : series) {
    drawCurve(curves.emplace_back(options.width, options.height), one, x, y, options.logY);
    curves.back().blendInto(image, one.colour);
  }
  drawLegend(image, x, y, series, options.band, curves);
  return image;
}

}  // namespace vdbtools
