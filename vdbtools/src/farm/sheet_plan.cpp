// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/plans.h"

#include "farm/variant_plan.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/frames.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"

#include <optional>
#include <set>
#include <stdexcept>

namespace vdbtools::farm {
namespace {

/// The cells of a list such as "3,7-9".
std::set<std::size_t> chosenCells(const std::string& file, const std::string& list, std::size_t count) {
  const auto refuseList = [&](const std::string& part) {
    throw std::invalid_argument("'" + file + "' has the cells 1 to " + std::to_string(count) + "; '" + part +
                                "' is none of them, and no range such as 3-9");
  };
  std::set<std::size_t> cells;
  for (const std::string& part : split(list, ',')) {
    const std::size_t dash = part.find('-');
    const auto first = wholeFromText<std::size_t>(part.substr(0, dash));
    const auto last = dash == std::string::npos ? first : wholeFromText<std::size_t>(part.substr(dash + 1));
    if (!first || !last || *first < 1 || *last < *first || *last > count) refuseList(part);
    for (std::size_t cell = *first; cell <= *last; ++cell)
      if (!cells.insert(cell).second)
        throw std::invalid_argument("cell " + std::to_string(cell) + " is given twice in '" + list + "'; give it once");
  }
  return cells;
}

std::set<std::size_t> cellsWithoutErrors(const std::string& file, const std::vector<SheetCell>& cells) {
  std::set<std::size_t> good;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i].error.empty()) good.insert(i + 1);
  if (good.empty()) throw DataError("every cell of '" + file + "' has an error; choose some by number to try them");
  return good;
}

}  // namespace

Manifest planSheetCells(const SheetPlanOptions& options) {
  Monitor monitor;
  return planSheetCells(options, monitor);
}

Manifest planSheetCells(const SheetPlanOptions& options, Monitor& monitor) {
  const std::size_t mark = options.cells.rfind('#');
  const std::string file = options.cells.substr(0, mark);
  const std::vector<SheetCell> cells = readSheetCells(file);
  const std::set<std::size_t> chosen = mark == std::string::npos
                                           ? cellsWithoutErrors(file, cells)
                                           : chosenCells(file, options.cells.substr(mark + 1), cells.size());
  const OptionTable table = fractalOptionTable();
  std::vector<Variant> variants;
  SceneMaker scenes;
  for (const std::size_t cell : chosen) {
    Recipe recipe = overridden(cells[cell - 1].recipe, options.given, table);
    // Machines with less or more memory must make the same files.
    if (hasAutomaticResolution(recipe))
      recipe = resolvedRecipe(scenes.make(parseFractalOptions(completeRecipe(recipe, table)), monitor), recipe);
    variants.push_back({static_cast<int>(cell), "cell " + std::to_string(cell), std::move(recipe)});
  }
  const std::string stem = stemWithoutFrame(file);
  return planVariants(PlanKind::Sheet, variants,
                      {options.name.empty() ? (stem.empty() ? "cell" : stem) : options.name, options.makes});
}

}  // namespace vdbtools::farm
