// SPDX-License-Identifier: Apache-2.0
/// @file contact_sheet.h
/// A page of pictures in rows and columns, each with a number and a caption below it.
#pragma once

#include "vdbtools/picture/canvas.h"

#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

struct ContactSheetOptions {
  int rows = 1, columns = 1;
  int cellWidth = 256, cellHeight = 256;  ///< of each picture, pixels
  int captionLines = 1;
};

/// Only one thread at a time may use it. Cells count from 0, row by row. Drawing a cell again overwrites it.
class ContactSheet {
 public:
  /// @throw std::invalid_argument  a page that is wider or higher than 32767 pixels
  explicit ContactSheet(const ContactSheetOptions& options);

  /// Draws the picture pixel for pixel. @return false if the bytes are not a PNG of a cell's size
  bool setPicture(int cell, std::string_view png);
  /// Draws a text instead of a picture, broken into lines and cut at the end of the cell.
  void setMessage(int cell, std::string_view utf8);
  /// @param lines  at most captionLines; the number precedes the first. Text that is too long is cut.
  void setCaption(int cell, int number, std::span<const std::string> lines);

  /// Returns the bytes of the file. @param extension  png or exr
  std::string encode(const std::string& extension) { return mCanvas.encode(extension); }

 private:
  CanvasBox boxOf(int cell) const;

  ContactSheetOptions mOptions;
  double mFont;  ///< pixels
  int mLine;     ///< from one baseline to the next, pixels
  Canvas mCanvas;
};

}  // namespace vdbtools
