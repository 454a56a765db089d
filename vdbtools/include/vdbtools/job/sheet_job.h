// SPDX-License-Identifier: Apache-2.0
/// @file sheet_job.h
/// Contact sheets: the fractals of one option's values, or of all pairs of two options' values, as small pictures on
/// one page. Each cell is what the field renderer (vdbtools/render/field_render.h) makes of the cell's recipe or, with
/// `--preview mesh`, what `render` shows of the mesh that `fractal` makes of it.
///
/// Pictures of the field show finer detail than any voxels. Each cell of such a sheet therefore says whether much of
/// what it shows is finer than the voxels of its recipe (vdbtools/scene/voxel_advice.h).
///
/// A finished cell is a PNG in a folder of its own, under a name that is a hash of everything that it depends on: the
/// complete recipe with the hashes of its files, the view, and the program's version. The next sheet that has the same
/// cell takes it from there.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/recipe/recipe.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

// The JSON beside a contact sheet: what was varied, and the recipe of each cell, from which `juliavdb fractal --config
// sheet.json#7` makes the fractal of cell 7. Cells count from 1, row by row.

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

// The sheet as a job.

inline constexpr std::size_t kMostSheetCells = 400;

/// The options of the cells' pictures: --preview, and those of vdbtools/render/view_options.h, where --size is the size
/// of a cell.
std::vector<OptionSpec> sheetViewOptionSpecs();
/// The options that a sheet can vary: those of a fractal, and those of the appearance of its picture (isAppearance()).
OptionTable variedOptionTable();

struct SheetOptions {
  /// One option, whose cells fill row after row; or two, the first for the rows and the second for the columns, unless
  /// the page would become a long strip.
  std::vector<VariedOption> varied;
  std::optional<int> columns;  ///< of a sheet that varies one option; empty: the page is about square
  Recipe base;                 ///< the options that all cells share; varied options override them
  Recipe given;                ///< those options of base that were requested as explicitly as the varied ones
  Recipe baseView;             ///< if this sheet continues from a cell of another one, the recorded view of that cell
  Recipe view;                 ///< options of sheetViewOptionSpecs() that override baseView, not completed
};

/// The files that the cells name, as far as their options can be read.
/// @throw std::invalid_argument  as planSheet()
InputFiles inputsOf(const SheetOptions& options);
/// The recipe of each cell, row by row, complete except for the hashes of its files. It includes recipes that are
/// refused, and there may be more of them than planSheet() allows.
std::vector<Recipe> cellRecipes(const SheetOptions& options);

/// The sheet of these options before any picture is made. A cell whose recipe is refused, or whose files cannot be
/// read, already has its error.
/// @throw std::invalid_argument  no or too many varied options, an option that is both varied and given, too many
///                               cells, or a bad view
Sheet planSheet(const SheetOptions& options);

/// Reports before the first cell is made that the sheet will take long.
struct LongWork {
  double seconds = 3600;                                 ///< the shortest time that is reported
  std::function<void(const std::string& words)> tell{};  ///< receives the message; empty: nothing is reported
};

struct SheetPage {
  Sheet sheet;                                               ///< has the errors of all cells that failed
  std::string picture;                                       ///< the page, as a PNG
  std::size_t reusedCells = 0;                               ///< number of cells that were taken from the folder
  std::vector<std::map<std::string, std::string>> metadata;  ///< of the scenes of the other cells
};

/// Makes the pictures and puts them on a page. A cell that cannot be made, or whose picture shows nothing of its set,
/// shows its error instead.
/// @param folder  for finished cells; created with the first of them
/// @throw std::invalid_argument, DataError, MissingInputError  as planSheet(); or the error of the first cell, if all
/// cells failed
/// @throw CreateError, IoError   the folder cannot be written
/// @throw Interrupted            finished cells are in the folder
/// @throw MemoryError            the page, or a cell's mesh, will not fit
SheetPage makeSheet(const SheetOptions& options, const std::filesystem::path& folder, Monitor& monitor,
                    const LongWork& longWork = {});

}  // namespace vdbtools
