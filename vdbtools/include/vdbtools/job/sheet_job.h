// SPDX-License-Identifier: Apache-2.0
/// @file sheet_job.h
/// Contact sheets: the fractals of one option's values, or of all pairs of two options' values, as small pictures on
/// one page. Each cell is what the field renderer (vdbtools/render/field_render.h) makes of the cell's recipe or, with
/// `--preview mesh`, what `render` shows of the mesh that `fractal` makes of it.
///
/// The field is finer than any voxels. A cell of it says where much of what it shows is finer than the voxels of its
/// recipe (vdbtools/scene/voxel_advice.h).
///
/// A finished cell is a PNG in a folder of its own, under a name that is a hash of everything that it depends on: the
/// complete recipe with the hashes of its files, the view, and the program's version. The next sheet that has the same
/// cell takes it from there.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/job/sheet_file.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/recipe/varied_option.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

inline constexpr std::size_t kMostSheetCells = 400;

/// The options of the cells' pictures: --preview, and those of vdbtools/render/view_options.h, with the size of a cell
/// for --size.
std::vector<OptionSpec> sheetViewOptionSpecs();
/// By its names, what may vary: the options of a fractal, and those of what its picture shows (isAppearance()).
OptionTable variedOptionTable();

struct SheetOptions {
  /// One, whose cells fill row after row; or two, the rows and the columns, as far as that makes no strip.
  std::vector<VariedOption> varied;
  std::optional<int> columns;  ///< of a sheet that varies one option; none: the page is about square
  Recipe base;                 ///< what the cells have in common; where a varied option says otherwise, that holds
  Recipe given;                ///< of these, what was asked for as firmly as what is varied
  Recipe baseView;             ///< of the cell of another sheet that this one goes on from, as it is recorded
  Recipe view;                 ///< what was given over it, by sheetViewOptionSpecs(), not completed
};

/// The files that the cells name, as far as their options can be read.
/// @throw std::invalid_argument  as planSheet()
InputFiles inputsOf(const SheetOptions& options);
/// The recipe of each cell, row by row, complete but for the hashes of its files. Recipes that are refused are among
/// them. There are as many as planSheet() allows, or more.
std::vector<Recipe> cellRecipes(const SheetOptions& options);

/// The sheet of these options before any picture is made. A cell whose recipe is refused, or whose files cannot be
/// read, has its error already.
/// @throw std::invalid_argument  none or too many varied options, one that is given too, too many cells, a bad view
Sheet planSheet(const SheetOptions& options);

/// Who is told, before the first cell is made, that all of them will take long.
struct LongWork {
  double seconds = 3600;                                 ///< from here on it is long
  std::function<void(const std::string& words)> tell{};  ///< not set: nobody
};

struct SheetPage {
  Sheet sheet;                                               ///< with the errors of all cells that failed
  std::string picture;                                       ///< the page, as a PNG
  std::size_t kept = 0;                                      ///< how many cells were taken from the folder
  std::vector<std::map<std::string, std::string>> metadata;  ///< of the scenes of the others
};

/// Makes the pictures and puts them on a page. A cell that cannot be made, or whose picture shows nothing of its set,
/// shows its error instead.
/// @param folder  for finished cells; made with the first of them
/// @throw std::invalid_argument, DataError, MissingInputError  as planSheet(), or what the first cell failed of if all
///                                                             cells failed
/// @throw CreateError, IoError   the folder cannot be written
/// @throw Interrupted            the cells that were finished are in the folder
/// @throw MemoryError            the page, or a cell's mesh, will not fit
SheetPage makeSheet(const SheetOptions& options, const std::filesystem::path& folder, Monitor& monitor,
                    const LongWork& longWork = {});

}  // namespace vdbtools
