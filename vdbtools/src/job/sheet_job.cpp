// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/sheet_job.h"

#include "job/file_hashes.h"

#include "vdbtools/base/numbered_monitor.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/file_hash.h"
#include "vdbtools/job/scene_picture.h"
#include "vdbtools/picture/contact_sheet.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <stdexcept>

namespace vdbtools {
namespace {

/// A cell, and what it failed of.
struct PlannedCell {
  SheetCell cell;
  std::exception_ptr failure;
};

struct Plan {
  Sheet sheet;  ///< without its cells
  std::vector<PlannedCell> cells;
  FieldPicture picture;
};

/// Runs the work on a cell. What goes wrong with its options, its set and its files is the cell's failure; other errors
/// are the whole sheet's.
template <class Work>
void guarded(PlannedCell& planned, const Work& work) {
  const auto fail = [&](const std::exception& error) {
    planned.failure = std::current_exception();
    planned.cell.error = inOneLine(error.what());
  };
  try {
    work();
  } catch (const std::invalid_argument& error) {
    fail(error);
  } catch (const DataError& error) {
    fail(error);
  } catch (const MissingInputError& error) {
    fail(error);
  }
}

/// As many columns as rows or a few more, so that few places stay empty; a few cells stand in one row.
int columnsFor(int cells) {
  constexpr int kOneRow = 5, kMore = 2;
  if (cells <= kOneRow) return cells;
  const int square = static_cast<int>(std::ceil(std::sqrt(cells)));
  const auto empty = [&](int columns) { return (columns - cells % columns) % columns; };
  int best = square;
  for (int columns = square + 1; columns <= square + kMore; ++columns)
    if (empty(columns) < empty(best)) best = columns;
  return best;
}

void layOut(const SheetOptions& options, Sheet& sheet) {
  const std::vector<VariedOption>& varied = options.varied;
  const auto count = [&](std::size_t i) { return static_cast<int>(varied[i].values.size()); };
  if (varied.size() == 1) {
    sheet.columns = std::min(options.columns.value_or(columnsFor(count(0))), count(0));
    sheet.rows = (count(0) + sheet.columns - 1) / sheet.columns;
    return;
  }
  if (options.columns)
    throw std::invalid_argument("--columns is " + std::to_string(*options.columns) +
                                "; it goes with one varied option only, for the values of the second are the columns");
  sheet.rows = count(0);
  sheet.columns = count(1);
}

void requireVaried(const SheetOptions& options) {
  const std::vector<VariedOption>& varied = options.varied;
  if (varied.empty())
    throw std::invalid_argument("nothing varies; use --vary NAME=VALUES, such as --vary alpha=10,20,40");
  if (varied.size() > 2)
    throw std::invalid_argument("--vary is given " + std::to_string(varied.size()) +
                                " times; a sheet has rows and columns, so vary one option or two");
  if (varied.size() == 2 && varied[0].name == varied[1].name)
    throw std::invalid_argument("--vary is given twice for '" + varied[0].name + "'; give all its values at once");
  for (const VariedOption& option : varied)
    if (options.given.contains(option.name))
      throw std::invalid_argument("--" + option.name + " is given and varied; give only one of them");
  std::size_t cells = 1;
  for (const VariedOption& option : varied) cells *= option.values.size();
  if (cells > kMostSheetCells)
    throw std::invalid_argument("the sheet would have " + std::to_string(cells) + " cells; it may have " +
                                std::to_string(kMostSheetCells) + ", so vary fewer values");
}

/// The varied options of each cell, row by row.
std::vector<Recipe> combinations(const std::vector<VariedOption>& varied) {
  std::vector<Recipe> cells{{}};
  for (const VariedOption& option : varied) {
    std::vector<Recipe> finer;
    for (const Recipe& cell : cells)
      for (const std::string& value : option.values) finer.emplace_back(cell)[option.name] = value;
    cells = std::move(finer);
  }
  return cells;
}

/// Complete, without the hashes of its files.
Recipe cellRecipe(const SheetOptions& options, const Recipe& varied, const OptionTable& table) {
  Recipe given = options.given;
  for (const auto& [name, value] : varied) given[name] = value;
  return completeRecipe(overridden(options.base, given, table), table);
}

Plan plan(const SheetOptions& options) {
  requireVaried(options);
  const OptionTable fractal = fractalOptionTable(), view(sheetViewOptionSpecs());
  Plan result{.picture = parseFieldPicture(options.view, view)};
  result.sheet.varied = options.varied;
  result.sheet.view = completeRecipe(options.view, view);
  layOut(options, result.sheet);
  FileHashes hashes;
  for (const Recipe& varied : combinations(options.varied)) {
    PlannedCell& planned = result.cells.emplace_back();
    planned.cell.varied = varied;
    Recipe& recipe = planned.cell.recipe;
    recipe = cellRecipe(options, varied, fractal);
    guarded(planned, [&] {
      for (const auto& [name, hash] : hashes.of(parseFractalOptions(recipe))) recipe[name] = hash;
    });
  }
  return result;
}

/// What a finished cell is called.
std::string fileNameOf(const SheetCell& cell, const Recipe& view) {
  constexpr std::size_t kDigits = 32;  // 128 bits
  const nlohmann::json all{{"program", JULIAVDB_VERSION}, {"recipe", cell.recipe}, {"view", view}};
  return sha256Hex(all.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)).substr(0, kDigits) + ".png";
}

/// "alpha 40"; of a file only its name.
std::string captionOf(const std::string& option, const std::string& value) {
  const std::size_t slash = value.find(':') == std::string::npos ? value.rfind('/') : std::string::npos;
  return option + " " + (slash == std::string::npos ? value : value.substr(slash + 1));
}

std::string makePicture(SceneMaker& scenes, const SheetCell& cell, const FieldPicture& picture, Monitor& monitor) {
  const Scene scene = scenes.make(parseFractalOptions(cell.recipe), monitor);
  const openvdb::BBoxd region = pictureRegion(scene);
  const FieldImage image =
      renderField(scene.source(), region, pictureOptions(scene, region, picture, FieldColour::Clay), monitor);
  if (std::all_of(image.id.begin(), image.id.end(), [](float id) { return id == 0; }))
    throw DataError("no ray of the picture meets the set: the set is empty, or out of view");
  return encodeFieldImage(image, "png");
}

/// The finished cells of this sheet and of others.
class CellFolder {
 public:
  explicit CellFolder(const std::filesystem::path& folder) : mFolder(folder) {
    std::error_code ignored;
    if (std::filesystem::exists(folder, ignored) && !std::filesystem::is_directory(folder, ignored))
      throw CreateError("'" + folder.string() + "' is in the way of the folder for finished cells; remove it");
  }

  /// Empty if there is none.
  std::string find(const std::string& name) const {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(mFolder / name, ignored)) return {};
    try {
      return readWholeFile(mFolder / name);
    } catch (const std::runtime_error&) {
      return {};  // it is made again
    }
  }

  void add(const std::string& name, const std::string& png) const {
    std::error_code error;
    std::filesystem::create_directories(mFolder, error);
    if (error) throw CreateError("cannot make the folder '" + mFolder.string() + "': " + error.message());
    AtomicFile file(mFolder / name);
    file.stream() << png;
    file.commit();
  }

 private:
  std::filesystem::path mFolder;
};

}  // namespace

std::vector<Recipe> cellRecipes(const SheetOptions& options) {
  const OptionTable table = fractalOptionTable();
  std::vector<Recipe> recipes;
  for (const Recipe& varied : combinations(options.varied)) recipes.push_back(cellRecipe(options, varied, table));
  return recipes;
}

std::vector<OptionSpec> sheetViewOptionSpecs() { return fieldPictureOptionSpecs("256x256"); }

InputFiles inputsOf(const SheetOptions& options) {
  requireVaried(options);
  InputFiles inputs;
  for (const Recipe& recipe : cellRecipes(options)) {
    try {
      inputs.add(inputsOf(parseFractalOptions(recipe)));
    } catch (const std::invalid_argument&) {
      // The cell will show why it cannot be made.
    }
  }
  return inputs;
}

Sheet planSheet(const SheetOptions& options) {
  Plan planned = plan(options);
  for (PlannedCell& cell : planned.cells) planned.sheet.cells.push_back(std::move(cell.cell));
  return std::move(planned.sheet);
}

SheetPage makeSheet(const SheetOptions& options, const std::filesystem::path& folder, Monitor& monitor) {
  Plan planned = plan(options);
  SheetPage page{.sheet = std::move(planned.sheet)};
  ContactSheet drawing({.rows = page.sheet.rows,
                        .columns = page.sheet.columns,
                        .cellWidth = planned.picture.render.width,
                        .cellHeight = planned.picture.render.height,
                        .captionLines = static_cast<int>(options.varied.size())});
  const CellFolder finished(folder);
  SceneMaker scenes;
  for (std::size_t i = 0; i < planned.cells.size(); ++i) {
    PlannedCell& cell = planned.cells[i];
    const int place = static_cast<int>(i);
    const std::string name = fileNameOf(cell.cell, page.sheet.view);
    if (!cell.failure && drawing.setPicture(place, finished.find(name))) {
      ++page.kept;
      continue;
    }
    guarded(cell, [&] {
      if (cell.failure) std::rethrow_exception(cell.failure);
      NumberedMonitor numbered(monitor, "cell", i + 1, planned.cells.size());
      const std::string png = makePicture(scenes, cell.cell, planned.picture, numbered);
      monitor.throwIfCancelled();
      finished.add(name, png);
      drawing.setPicture(place, png);
    });
    if (cell.failure) drawing.setMessage(place, cell.cell.error);
  }
  const auto failed = [](const PlannedCell& cell) { return cell.failure != nullptr; };
  if (std::all_of(planned.cells.begin(), planned.cells.end(), failed))
    std::rethrow_exception(planned.cells.front().failure);

  for (std::size_t i = 0; i < planned.cells.size(); ++i) {
    SheetCell& cell = planned.cells[i].cell;
    std::vector<std::string> caption;
    for (const VariedOption& option : page.sheet.varied)
      caption.push_back(captionOf(option.name, cell.varied.at(option.name)));
    drawing.setCaption(static_cast<int>(i), static_cast<int>(i) + 1, caption);
    page.sheet.cells.push_back(std::move(cell));
  }
  page.picture = drawing.encode("png");
  return page;
}

}  // namespace vdbtools
