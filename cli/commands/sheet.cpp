// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"
#include "target_text.h"

#include "vdbtools/job/sheet_job.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <algorithm>
#include <ostream>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kSheetUsage = {
    "sheet",
    "MESH|SDF.vdb|FRACTAL.vdb -o F.png --vary NAME=VALUES [--vary NAME=VALUES] [options]",
    "Makes a contact sheet: a small picture for each value of an option of 'fractal', or for each pair of values of "
    "two options. Of one option the cells fill row after row; of two, the first varies from row to row and the second "
    "from column to column, unless the page were a strip then. A cell whose options are refused, or which shows "
    "nothing, shows its error.\n\n"
    "A cell shows the set itself, and says if much of it is finer than the voxels of its --resolution. With --preview "
    "mesh it shows the mesh that 'fractal' makes at that resolution, as 'render' does.\n\n"
    "  NAME=A,B,C       these values; with semicolons between them the values themselves may hold commas\n"
    "  NAME=A:B:STEP    the values A, A + STEP and so on, up to B\n\n"
    "F.json beside the picture holds the recipe of each cell. Cells count from 1, row by row, and the number stands in "
    "the caption: 'juliavdb fractal --config F.json#7 -o out.vdb' makes the fractal of cell 7, and 'juliavdb render "
    "--field --config F.json#7 -o large.png' shows the set at a larger size, from the same side and in the same light. "
    "Finished cells are kept in the folder F.cells. The next run makes only those that are not there, also after an "
    "interruption or for a sheet with more values. Remove the folder when you no longer need it.",
    "  juliavdb sheet bunny.obj -o alpha.png --vary alpha=10,20,40,80\n"
    "  juliavdb sheet bunny.obj -o seeds.png --vary alpha=20:60:20 --vary texture-seed=1:4:1 --size 160x160\n"
    "  juliavdb sheet bunny.obj -o meshes.png --vary detail=0.1,0.3,0.5 --preview mesh --resolution 80\n"
    "  juliavdb sheet bunny.obj -o looks.png --vary material=clay,bronze,jade --ground --light 60,25\n"
    "  juliavdb sheet --config seeds.json#3 -o next.png --vary \"texture-translate=0,0,0;0.1,0,0;0.2,0,0\"\n",
    "fractal",
    nullptr,
    "up"};

/// The path of the JSON beside a picture. An existing file is overwritten only if it is a sheet of this program.
std::filesystem::path recipesBeside(const std::filesystem::path& picture) {
  std::filesystem::path path = picture;
  path.replace_extension(".json");
  if (std::filesystem::exists(path) && !vdbtools::isSheetFile(path))
    throw vdbtools::CreateError("'" + path.string() +
                                "' exists and is no contact sheet; the recipes of the cells go there, so give the "
                                "picture another name");
  return path;
}

/// The options of the command line, of --config, and of the target's own recipe.
vdbtools::SheetOptions parseSheet(const CommandLine& line) {
  const vdbtools::OptionTable table = vdbtools::variedOptionTable();
  vdbtools::SheetOptions options;
  for (const std::string& text : line.texts("vary"))
    options.varied.push_back(vdbtools::parseVaried(text, table, vdbtools::kMostSheetCells));
  if (line.has("columns")) options.columns = line.integer("columns", 1, static_cast<int>(vdbtools::kMostSheetCells));
  options.base = givenSceneRecipe(line, line.text("input"));
  options.given = line.given();
  // If the target is the file of a fractal, that stands for its recipe, which names the actual target.
  const auto target = options.base.find("input");
  if (target == options.base.end() || target->second != line.text("input")) options.given.erase("input");
  if (line.has("config")) options.baseView = vdbtools::readRecordedView(line.text("config"));
  options.view = line.given(vdbtools::OptionTable(vdbtools::sheetViewOptionSpecs()));
  return options;
}

/// Checks that all typed and varied options have an effect in some cell.
void requireEffects(const CommandLine& line, const vdbtools::SheetOptions& options) {
  std::set<std::string> names = line.typedNames();
  const vdbtools::OptionTable fractal = vdbtools::fractalOptionTable();
  for (const vdbtools::VariedOption& varied : options.varied)
    if (fractal.knows(varied.name)) names.insert(varied.name);
  std::vector<vdbtools::OptionRun> runs;
  for (const vdbtools::Recipe& recipe : vdbtools::cellRecipes(options))
    runs.push_back({recipe, {vdbtools::Product::Recipe}});
  line.requireEffect(std::move(names), runs);
}

/// Reports once what several cells show that their voxels do not.
void tellFiner(const std::vector<vdbtools::SheetCell>& cells) {
  const auto isFiner = [](const vdbtools::SheetCell& cell) { return !cell.finer.empty(); };
  const auto count = std::count_if(cells.begin(), cells.end(), isFiner);
  report().count("finerCells", count);
  if (count == 0) return;
  const auto first = std::find_if(cells.begin(), cells.end(), isFiner);
  report().text() << "warning: " << count << (count == 1 ? " cell shows" : " cells show")
                  << " more than voxels will; cell " << first - cells.begin() + 1 << ": " << first->finer
                  << "; --preview mesh shows what the voxels hold\n";
}

}  // namespace

int runSheet(const Arguments& arguments) {
  CommandLine line(kSheetUsage, vdbtools::fractalOptionTable());
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.png"),
                    "the picture to write; F.json goes with it")(
      "vary", po::value<std::vector<std::string>>()->value_name("NAME=VALUES"),
      "an option of 'fractal', or of the camera and the light, and its values; once or twice")(
      "columns", po::value<std::string>()->value_name("N"),
      "how many cells stand in a row, where one option varies (default: so many that the page is about square)");
  line.addOptions(vdbtools::sheetViewOptionSpecs());
  addSearchOption(line);
  if (!line.parse(arguments)) return kDone;
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  const vdbtools::SheetOptions options = parseSheet(line);
  requireEffects(line, options);
  const std::filesystem::path picture = line.text("output");
  if (std::filesystem::exists(picture) && !std::filesystem::is_regular_file(picture) &&
      !std::filesystem::is_directory(picture))
    line.refuse("output", "a file, for the recipes go beside it");
  Outputs outputs(line, vdbtools::inputsOf(options));
  std::ostream& page = outputs.add("output", picture.string(), ".png").stream();
  std::ostream& recipes = outputs.add("output", recipesBeside(picture).string(), ".json").stream();
  std::filesystem::path folder = picture;
  folder.replace_extension(".cells");

  Progress& progress = line.progress();
  report().noteKept("finished cells are kept in '" + folder.string() + "', and the same command goes on from there");
  const vdbtools::SheetPage made =
      vdbtools::makeSheet(options, folder, progress, {.tell = [](const std::string& words) {
                            report().text() << "warning: " << words << '\n' << std::flush;
                          }});
  progress.begin(vdbtools::PhaseKind::Writing, 0);
  page << made.picture;
  recipes << vdbtools::encodeSheet(made.sheet);
  progress.throwIfCancelled();
  outputs.commit();
  const std::vector<vdbtools::SheetCell>& cells = made.sheet.cells;
  const auto failed = std::count_if(cells.begin(), cells.end(), [](const auto& cell) { return !cell.error.empty(); });
  report().count("cells", cells.size());
  report().count("keptCells", made.reusedCells);
  report().count("failedCells", failed);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!cells[i].error.empty()) report().text() << "warning: cell " << i + 1 << " failed: " << cells[i].error << '\n';
  tellFiner(cells);
  report().text() << "wrote " << outputs.names() << ": " << made.sheet.rows << " x " << made.sheet.columns << " cells, "
                  << made.reusedCells << " of " << cells.size() << " cells kept\n";
  for (const auto& metadata : made.metadata) tellTarget(metadata);
  return kDone;
}

}  // namespace cli
