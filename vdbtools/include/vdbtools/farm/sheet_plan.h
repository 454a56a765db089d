// SPDX-License-Identifier: Apache-2.0
/// @file sheet_plan.h
/// Plans the fractals of cells of a contact sheet (vdbtools/job/sheet_file.h).
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/manifest.h"

#include <string>
#include <vector>

namespace vdbtools::farm {

struct SheetPlanOptions {
  std::string cells;                      ///< "sheet.json#3,7-9", or "sheet.json" for every cell without an error
  Recipe given;                           ///< options that override the cells' options, such as a higher resolution
  std::string name;                       ///< base name of the files; empty: named after the sheet
  std::vector<std::string> makes{"vdb"};  ///< any of writtenFormats()
};

/// Plans a task for each cell, in the order of the cells. The files are out/NAME.0007.vdb and the like, with the cell's
/// number.
/// @throw std::invalid_argument  there is no such cell, or an option is refused (the message names the cell)
/// @throw DataError              the file is not a contact sheet, all its cells have errors, or a file that a cell
///                               names has changed
/// @throw MissingInputError, IoError
/// @throw as makeScene(), if a cell has `--resolution auto`, which is replaced by its number
Manifest planSheetCells(const SheetPlanOptions& options, Monitor& monitor);
Manifest planSheetCells(const SheetPlanOptions& options);

}  // namespace vdbtools::farm
