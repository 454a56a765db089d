// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/plot.h"

#include "base/elementary.h"
#include "picture/plot_axis.h"

#include "vdbtools/picture/canvas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLargest = 1e307;  ///< keeps differences of numbers finite

constexpr Colour kWhite{1, 1, 1}, kInk{0.02F, 0.02F, 0.02F}, kAxis{0.15F, 0.15F, 0.15F}, kGridLine{0.76F, 0.76F, 0.76F},
    kMinorGridLine{0.89F, 0.89F, 0.89F};

// All lengths are in pixels.
constexpr double kCurveWidth = 2.2;
constexpr double kGap = 10;                              ///< between elements that must not touch
constexpr double kRightMargin = 22;                      ///< right of the axes, for half a tick's label
constexpr double kTickLength = 5, kMinorTickLength = 3;  ///< outwards from the axes
constexpr double kTickSpacing = 90, kTickSpacingY = 50;  ///< minimum distances between labelled ticks
constexpr double kTickTextSize = 13, kTextSize = 14, kTitleSize = 17;
constexpr double kLegendRow = 22, kLegendKey = 30;  ///< height of a row, length of a curve's sample
constexpr double kLegendOpacity = 0.92;

const TextStyle kTickText{.size = kTickTextSize, .colour = kInk};
const TextStyle kLegendText{.size = kTextSize, .colour = kInk};

/// The centre of the pixel that contains a position, where lines of 1 pixel are sharp.
double sharp(double position) { return std::floor(position) + 0.5; }

using PlacedPoint = std::optional<CanvasPoint>;

/// The coordinates on the axes; empty for a point that cannot be drawn.
PlacedPoint onAxes(const std::pair<double, double>& point, bool logY) {
  const double y = logY ? (point.second > 0 ? elementary::log10(point.second) : NAN) : point.second;
  if (!(std::abs(point.first) < kLargest && std::abs(y) < kLargest)) return std::nullopt;
  return CanvasPoint{point.first, y};
}

void requireDrawable(const Plot& plot) {
  constexpr int kLeastWidth = 200, kLeastHeight = 150, kMost = 4096;
  if (plot.width < kLeastWidth || plot.height < kLeastHeight || plot.width > kMost || plot.height > kMost)
    throw std::invalid_argument("a plot of " + std::to_string(plot.width) + " x " + std::to_string(plot.height) +
                                " pixels cannot be drawn; use 200 x 150 to 4096 x 4096");
  if (plot.band && plot.logY)
    throw std::invalid_argument("a band cannot be drawn with a logarithmic y axis; use a linear one");
  for (const PlotSeries& series : plot.series)
    for (const auto& point : series.points)
      if (onAxes(point, plot.logY)) return;
  throw std::invalid_argument(std::string("there is nothing to plot: no series has a point that is finite") +
                              (plot.logY ? " and above 0" : ""));
}

/// Draws one plot over all of a canvas.
class Plotter {
 public:
  Plotter(Canvas& canvas, const Plot& plot) : mCanvas(canvas), mPlot(plot) {}

  void draw() {
    layAxes();
    placeCurves();
    drawBand();
    drawGrid();
    drawAxes();
    for (std::size_t i = 0; i < mRuns.size(); ++i)
      for (const std::vector<CanvasPoint>& run : mRuns[i]) mCanvas.line(run, curveStyle(mPlot.series[i]));
    drawLegend();
  }

 private:
  struct Entry {
    std::string name;
    Colour colour;
    bool isBand;
  };

  static LineStyle curveStyle(const PlotSeries& series) { return {series.colour, kCurveWidth}; }

  void layAxes() {
    mX.low = mY.low = kInfinity;
    mX.high = mY.high = -kInfinity;
    for (const PlotSeries& series : mPlot.series)
      for (const auto& point : series.points)
        if (const PlacedPoint here = onAxes(point, mPlot.logY)) {
          mX.low = std::min(mX.low, here->x);
          mX.high = std::max(mX.high, here->x);
          mY.low = std::min(mY.low, here->y);
          mY.high = std::max(mY.high, here->y);
        }
    const double tickLabels = kTickLength + kGap / 2 + kTickTextSize;
    mY.first = sharp(mCanvas.height() - tickLabels - kGap - (mPlot.xLabel.empty() ? 0 : kTextSize + kGap));
    mY.last = sharp(mPlot.title.empty() ? 2 * kGap : kTitleSize + 2.4 * kGap);
    if (mPlot.logY)
      addLogarithmicTicks(mY, kTickSpacingY);
    else
      addLinearTicks(mY, kTickSpacingY, true);
    double widest = 0;
    for (const PlotTick& tick : mY.ticks) widest = std::max(widest, mCanvas.textWidth(tick.label, kTickText));
    mX.first = sharp((mPlot.yLabel.empty() ? 0 : kTextSize + kGap) + widest + kTickLength + 2 * kGap);
    mX.last = sharp(mCanvas.width() - kRightMargin);
    addLinearTicks(mX, kTickSpacing, false);
  }

  /// The curves in pixels, split where points cannot be drawn.
  void placeCurves() {
    for (const PlotSeries& series : mPlot.series) {
      std::vector<std::vector<CanvasPoint>>& runs = mRuns.emplace_back();
      bool joined = false;
      for (const auto& point : series.points) {
        const PlacedPoint here = onAxes(point, mPlot.logY);
        if (here && !joined) runs.emplace_back();
        if (here) runs.back().push_back({mX.pixel(here->x), mY.pixel(here->y)});
        joined = here.has_value();
      }
    }
  }

  void drawBand() {
    if (!mPlot.band) return;
    const auto row = [&](double value) { return mY.pixel(std::clamp(value, mY.low, mY.high)); };
    const double top = row(mPlot.band->high), bottom = row(mPlot.band->low);
    mCanvas.fill({mX.first, top, mX.last - mX.first, bottom - top}, mPlot.band->colour);
  }

  void segment(double x0, double y0, double x1, double y1, const Colour& colour) {
    const CanvasPoint ends[] = {{x0, y0}, {x1, y1}};
    mCanvas.line(ends, {colour, 1});
  }

  void drawGrid() {
    for (const bool minor : {true, false}) {
      const Colour& colour = minor ? kMinorGridLine : kGridLine;
      for (const PlotTick& tick : mX.ticks)
        if (tick.label.empty() == minor)
          segment(sharp(mX.pixel(tick.value)), mY.last, sharp(mX.pixel(tick.value)), mY.first, colour);
      for (const PlotTick& tick : mY.ticks)
        if (tick.label.empty() == minor)
          segment(mX.first, sharp(mY.pixel(tick.value)), mX.last, sharp(mY.pixel(tick.value)), colour);
    }
  }

  void drawAxes() {
    segment(mX.first, mY.first, mX.last, mY.first, kAxis);
    segment(mX.first, mY.first, mX.first, mY.last, kAxis);
    TextStyle text = kTickText;
    text.align = TextAlign::Centre;
    const double baseline = mY.first + kTickLength + kGap / 2 + kCapHeight * kTickTextSize;
    for (const PlotTick& tick : mX.ticks) {
      const double at = sharp(mX.pixel(tick.value));
      segment(at, mY.first, at, mY.first + kTickLength, kAxis);
      const double half = mCanvas.textWidth(tick.label, text) / 2;
      mCanvas.text(tick.label, {std::min(at, mCanvas.width() - half - 2), baseline}, text);
    }
    text.align = TextAlign::Right;
    for (const PlotTick& tick : mY.ticks) {
      const double at = sharp(mY.pixel(tick.value));
      segment(mX.first - (tick.label.empty() ? kMinorTickLength : kTickLength), at, mX.first, at, kAxis);
      mCanvas.text(tick.label, {mX.first - kTickLength - kGap / 2, at + kCapHeight * kTickTextSize / 2}, text);
    }
    const double middle = (mX.first + mX.last) / 2;
    TextStyle label{.size = kTextSize, .align = TextAlign::Centre, .colour = kInk};
    mCanvas.text(mPlot.xLabel, {middle, mCanvas.height() - kGap}, label);
    label.upwards = true;
    mCanvas.text(mPlot.yLabel, {kGap + kCapHeight * kTextSize, (mY.first + mY.last) / 2}, label);
    const TextStyle title{.size = kTitleSize, .align = TextAlign::Centre, .colour = kInk};
    mCanvas.text(mPlot.title, {middle, kGap + kTitleSize * 0.9}, title);
  }

  std::vector<Entry> legendEntries() const {
    std::vector<Entry> entries;
    for (const PlotSeries& series : mPlot.series) entries.push_back({series.name, series.colour, false});
    if (mPlot.band) entries.push_back({mPlot.band->name, mPlot.band->colour, true});
    std::erase_if(entries, [](const Entry& entry) { return entry.name.empty(); });
    return entries;
  }

  /// The length of the curves covered by a box.
  double hidden(const CanvasBox& box) const {
    double length = 0;
    for (const auto& runs : mRuns)
      for (const std::vector<CanvasPoint>& run : runs)
        for (std::size_t i = 1; i < run.size(); ++i) {
          const double dx = run[i].x - run[i - 1].x, dy = run[i].y - run[i - 1].y, whole = elementary::hypot(dx, dy);
          const int steps = 1 + static_cast<int>(whole);
          for (int step = 0; step < steps; ++step) {
            const double x = run[i - 1].x + dx * step / steps, y = run[i - 1].y + dy * step / steps;
            if (x > box.left && x < box.left + box.width && y > box.top && y < box.top + box.height)
              length += whole / steps;
          }
        }
    return length;
  }

  /// Draws the legend in the corner of the axes where it covers least of the curves.
  void drawLegend() {
    const std::vector<Entry> entries = legendEntries();
    if (entries.empty()) return;
    double widest = 0;
    for (const Entry& entry : entries) widest = std::max(widest, mCanvas.textWidth(entry.name, kLegendText));
    CanvasBox best{0, 0, std::ceil(kLegendKey + 3 * kGap + widest),
                   kLegendRow * static_cast<double>(entries.size()) + kGap};
    double least = kInfinity;
    for (const double top : {mY.last + kGap, mY.first - kGap - best.height})
      for (const double left : {mX.last - kGap - best.width, mX.first + kGap}) {
        const CanvasBox box{left, top, best.width, best.height};
        const double length = hidden(box);
        if (length >= least) continue;
        least = length;
        best = box;
      }
    mCanvas.fill(best, kWhite, kLegendOpacity);
    const double right = best.left + best.width, bottom = best.top + best.height;
    const CanvasPoint frame[] = {
        {best.left, best.top}, {right, best.top}, {right, bottom}, {best.left, bottom}, {best.left, best.top}};
    mCanvas.line(frame, {kGridLine, 1});
    double middle = best.top + (kGap + kLegendRow) / 2;
    for (const Entry& entry : entries) {
      const double left = best.left + kGap;
      const double half = kCapHeight * kTextSize / 2;
      const CanvasPoint key[] = {{left, middle}, {left + kLegendKey, middle}};
      if (entry.isBand)
        mCanvas.fill({left, middle - half, kLegendKey, 2 * half}, entry.colour);
      else
        mCanvas.line(key, {entry.colour, kCurveWidth});
      mCanvas.text(entry.name, {left + kLegendKey + kGap, middle + half}, kLegendText);
      middle += kLegendRow;
    }
  }

  Canvas& mCanvas;
  const Plot& mPlot;
  PlotAxis mX, mY;
  std::vector<std::vector<std::vector<CanvasPoint>>> mRuns;  ///< for each series, its pieces between gaps, in pixels
};

Canvas drawn(const Plot& plot, CanvasKind kind) {
  requireDrawable(plot);
  Canvas canvas(kind, plot.width, plot.height);
  Plotter(canvas, plot).draw();
  return canvas;
}

}  // namespace

Image plotImage(const Plot& plot) { return drawn(plot, CanvasKind::Pixels).pixels(); }

std::string encodePlot(const Plot& plot, const std::string& extension) {
  return drawn(plot, canvasKindOf(extension)).encode(extension);
}

}  // namespace vdbtools
