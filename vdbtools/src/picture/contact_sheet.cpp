// SPDX-License-Identifier: Apache-2.0
#include "picture/contact_sheet.h"

#include "vdbtools/base/text.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbtools {
namespace {

constexpr int kMargin = 20, kCellGap = 16;  ///< around the page and between cells, pixels
constexpr Colour kPage{0.93F, 0.93F, 0.92F}, kBlank{0.78F, 0.78F, 0.77F};
constexpr Colour kLabelInk{0.015F, 0.015F, 0.015F}, kError{0.33F, 0.02F, 0.015F};
constexpr const char* kEllipsis = "\u2026";

double fontFor(const ContactSheetOptions& options) {
  constexpr double kPart = 19, kLeast = 9, kMost = 18;  // fraction of the cell's width; limits in pixels
  return std::clamp(options.cellWidth / kPart, kLeast, kMost);
}

int lineFor(const ContactSheetOptions& options) { return static_cast<int>(std::lround(1.35 * fontFor(options))); }

int captionHeight(const ContactSheetOptions& options) {
  return options.captionLines * lineFor(options) + lineFor(options) / 3;
}

int side(int cells, int size) { return 2 * kMargin + cells * size + (cells - 1) * kCellGap; }

/// @a text without its last character.
std::string_view shorter(std::string_view text) { return text.substr(0, characterAt(text, text.size() - 1)); }

/// The text, shortened if it is wider than @a width.
std::string cut(const Canvas& canvas, std::string_view text, double width, const TextStyle& style) {
  if (canvas.textWidth(text, style) <= width) return std::string(text);
  while (!text.empty() && canvas.textWidth(std::string(text) + kEllipsis, style) > width) text = shorter(text);
  return text.empty() ? std::string() : std::string(text) + kEllipsis;
}

/// The text in lines no wider than @a width, broken between words where that is possible.
std::vector<std::string> wrapped(const Canvas& canvas, std::string_view text, double width, const TextStyle& style) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    std::string_view line = text;
    while (canvas.textWidth(line, style) > width && line.size() > 1) {
      const std::size_t blank = line.rfind(' ');
      line = blank != std::string_view::npos && blank > 0 ? line.substr(0, blank) : shorter(line);
    }
    if (line.empty()) break;  // not even one character fits
    lines.emplace_back(line);
    text.remove_prefix(line.size());
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  }
  return lines;
}

}  // namespace

ContactSheet::ContactSheet(const ContactSheetOptions& options)
    : mOptions(options),
      mFont(fontFor(options)),
      mLine(lineFor(options)),
      mCanvas(CanvasKind::Pixels, side(options.columns, options.cellWidth),
              side(options.rows, options.cellHeight + captionHeight(options)), kPage) {}

CanvasBox ContactSheet::boxOf(int cell) const {
  const int column = cell % mOptions.columns, row = cell / mOptions.columns;
  const int height = mOptions.cellHeight + captionHeight(mOptions);
  return {static_cast<double>(kMargin + column * (mOptions.cellWidth + kCellGap)),
          static_cast<double>(kMargin + row * (height + kCellGap)), static_cast<double>(mOptions.cellWidth),
          static_cast<double>(mOptions.cellHeight)};
}

bool ContactSheet::setPicture(int cell, std::string_view png) { return mCanvas.png(png, boxOf(cell)); }

void ContactSheet::setMessage(int cell, std::string_view utf8) {
  const CanvasBox box = boxOf(cell);
  mCanvas.fill(box, kBlank);
  const TextStyle style{.size = mFont, .colour = kError};
  const double inner = box.width - 2 * mFont;
  std::vector<std::string> lines = wrapped(mCanvas, utf8, inner, style);
  const auto room = static_cast<std::size_t>(std::max(0.0, (box.height - 2 * mFont) / mLine));
  if (lines.size() > room) {
    lines.resize(room);
    if (!lines.empty()) lines.back() = cut(mCanvas, lines.back() + " " + kEllipsis, inner, style);
  }
  double y = box.top + mFont + mLine * 0.8;
  for (const std::string& line : lines) {
    mCanvas.text(line, {box.left + mFont, y}, style);
    y += mLine;
  }
}

void ContactSheet::setCaption(int cell, int number, std::span<const std::string> lines) {
  const CanvasBox box = boxOf(cell);
  const double top = box.top + box.height;
  mCanvas.fill(CanvasBox{box.left, top, box.width, static_cast<double>(captionHeight(mOptions))}, kPage);
  const TextStyle bold{.size = mFont, .bold = true, .colour = kLabelInk}, plain{.size = mFont, .colour = kLabelInk};
  const std::string mark = std::to_string(number);
  const double indent = mCanvas.textWidth(mark, bold) + 0.6 * mFont;
  double y = top + mLine;
  mCanvas.text(mark, {box.left, y}, bold);
  for (const std::string& line : lines) {
    mCanvas.text(cut(mCanvas, line, box.width - indent, plain), {box.left + indent, y}, plain);
    y += mLine;
  }
}

}  // namespace vdbtools
