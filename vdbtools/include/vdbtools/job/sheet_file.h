// SPDX-License-Identifier: Apache-2.0
/// @file sheet_file.h
/// The JSON beside a contact sheet: what was varied, and the recipe of each cell, from which `juliavdb fractal --config
/// sheet.json#7` makes the fractal of cell 7. Cells count from 1, row by row.
#pragma once

#include "vdbtools/recipe/recipe.h"
#include "vdbtools/recipe/varied_option.h"

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools {

struct SheetCell {
  Recipe varied;      ///< the varied options alone
  Recipe recipe;      ///< complete, with the hashes of its files where these could be read
  std::string error;  ///< why there is no picture; empty: there is one
  std::string finer;  ///< what the picture shows and the voxels of the recipe do not; empty: little or nothing
  /// Where the picture is seen from and in which light, complete, as options of `render`; empty where these are
  /// refused.
  Recipe view{};
};

struct Sheet {
  std::vector<VariedOption> varied;
  int rows = 0, columns = 0;
  Recipe view;                   ///< what the pictures are taken with, complete but for what varies
  std::vector<SheetCell> cells;  ///< row by row
};

std::string encodeSheet(const Sheet& sheet);

/// Whether the file holds a contact sheet; false also where it cannot be read.
bool isSheetFile(const std::filesystem::path& path);

/// Whether a name is one that readSheetCell() takes: "sheet.json#7", or "sheet.json", which lacks the cell.
bool isSheetCell(const std::string& name);
/// The name of the sheet alone, "sheet.json".
std::string sheetOfCell(const std::string& name);

/// Every cell of a contact sheet, row by row.
/// @throw DataError  the file is no contact sheet, or broken; MissingInputError, IoError
std::vector<SheetCell> readSheetCells(const std::filesystem::path& path);

/// @param name  such as "sheet.json#7"
/// @throw std::invalid_argument  no number, or none of a cell
/// @throw DataError              the file is no contact sheet, or broken
/// @throw MissingInputError, IoError
SheetCell readSheetCell(const std::string& name);

}  // namespace vdbtools
