// SPDX-License-Identifier: Apache-2.0
/// @file sheet_plan.h
/// Plans of cells of a contact sheet (vdbtools/job/sheet_file.h): the fractal of each.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/manifest.h"

#include <string>
#include <vector>

namespace vdbtools::farm {

struct SheetPlanOptions {
  std::string cells;                      ///< "sheet.json#3,7-9", or "sheet.json" for every cell without an error
  Recipe given;                           ///< options that stand over those of the cells, such as a higher resolution
  std::string name;                       ///< of the files; empty: after the sheet
  std::vector<std::string> makes{"vdb"};  ///< of "vdb" and the formats of meshes
};

/// A task for each cell, in the order of the cells. The files are out/NAME.0007.vdb and the like, by the cell's number.
/// @throw std::invalid_argument  no such cell, or an option is refused, with the cell
/// @throw DataError              the file is no contact sheet, all its cells have errors, or a file that a cell names
///                               has changed
/// @throw MissingInputError, IoError; where a cell has `--resolution auto`, which becomes its number, as makeScene()
Manifest planSheetCells(const SheetPlanOptions& options, Monitor& monitor);
Manifest planSheetCells(const SheetPlanOptions& options);

}  // namespace vdbtools::farm
