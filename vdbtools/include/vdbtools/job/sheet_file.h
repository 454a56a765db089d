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
  std::string
      finer;  ///< a sentence about what the picture shows but the voxels of the recipe do not; empty: little or nothing
  /// The camera and the light of the picture, complete, as options of `render`; empty if these are refused.
  Recipe view{};
};

struct Sheet {
  std::vector<VariedOption> varied;
  int rows = 0, columns = 0;
  Recipe view;                   ///< the camera and the light of all pictures, complete except for varied options
  std::vector<SheetCell> cells;  ///< row by row
};

std::string encodeSheet(const Sheet& sheet);

/// Whether the file is a contact sheet. Also false if it cannot be read.
bool isSheetFile(const std::filesystem::path& path);

/// Whether a name has the form that readSheetCell() takes: "sheet.json#7", or "sheet.json" without the number of a
/// cell.
bool isSheetCell(const std::string& name);
/// The name without the number of the cell: "sheet.json".
std::string sheetOfCell(const std::string& name);

/// Every cell of a contact sheet, row by row.
/// @throw DataError  the file is not a contact sheet, or broken; MissingInputError, IoError
std::vector<SheetCell> readSheetCells(const std::filesystem::path& path);

/// @param name  such as "sheet.json#7"
/// @throw std::invalid_argument  the number is missing, or there is no cell with this number
/// @throw DataError              the file is not a contact sheet, or broken
/// @throw MissingInputError, IoError
SheetCell readSheetCell(const std::string& name);

}  // namespace vdbtools
