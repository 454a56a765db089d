// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"

#include "vdbtools/farm/plans.h"
#include "vdbtools/scene/fractal_options.h"

#include <stdexcept>

namespace cli {
namespace {

constexpr Usage kPlanSheetUsage = {"plan sheet", "SHEET.json[#CELLS] -o DIR [--make LIST] [options]",
                                   "Plans the fractals of cells of a contact sheet, which 'juliavdb sheet' has made. "
                                   "CELLS is a list such as 3,7,10-12; without it every cell without an error is "
                                   "planned. Options stand over those of all cells, such as a higher --resolution.",
                                   "  juliavdb plan sheet seeds.json#3,5-7 -o chosen --resolution 200 --make vdb,ply\n"
                                   "  juliavdb plan sheet seeds.json -o all\n"};

}  // namespace

int runPlanSheet(const Arguments& arguments) {
  CommandLine line(kPlanSheetUsage, vdbtools::fractalOptionTable());
  addVariantOptions(line);
  if (!line.parse(arguments)) return kDone;
  if (line.has("config"))
    throw std::invalid_argument("--config is given, but each cell has a recipe of its own; leave it out");
  vdbtools::farm::SheetPlanOptions options{
      .cells = line.text("input"), .given = line.given(), .name = line.text("name"), .makes = parseMakes(line)};
  if (options.cells.empty()) throw std::invalid_argument("no contact sheet was given, such as sheet.json#3,7");
  options.given.erase("input");
  const std::filesystem::path folder = newPlanFolder(line);
  const vdbtools::farm::Manifest manifest = vdbtools::farm::planSheetCells(options, line.progress());
  std::vector<vdbtools::OptionRun> runs;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index)
    runs.push_back({vdbtools::farm::taskRecipe(manifest, index), productsOf(options.makes)});
  line.requireEffect(line.typedNames(), runs);
  return finishPlan(folder, manifest);
}

}  // namespace cli
