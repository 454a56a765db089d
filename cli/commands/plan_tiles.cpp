// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include "exit_code.h"
#include "options.h"
#include "report.h"

#include "vdbtools/farm/plan_folder.h"
#include "vdbtools/farm/tile_plan.h"
#include "vdbtools/job/fractal_options.h"

#include <limits>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kUsageText = {
    "plan tiles", "MESH|SDF.vdb -o DIR [--tiles N | --tile-nodes K] [--make LIST] [options of fractal]",
    "Cuts one fractal into tiles, boxes of lattice nodes. Any number of machines make them, and 'juliavdb merge' puts\n"
    "them together into the files that one run would have made, byte for byte. The distances and the exponent are "
    "made\n"
    "once, here, and the tasks read them.\n"
    "\n"
    "--tiles cuts the lattice into tiles of about equal work. --tile-nodes cuts it into cubes and leaves out those in\n"
    "which there is nothing to do.",
    "  juliavdb plan tiles bunny.obj -o farm --tiles 16 --resolution 150\n"
    "  juliavdb plan tiles bunny.obj -o cubes --tile-nodes 64 --make ply --resolution 150 --detail 0.4\n",
    "fractal"};

}  // namespace

int planTiles(const Arguments& arguments) {
  CommandLine line(kUsageText, vdbtools::fractalOptionTable());
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("DIR"), "the folder of the plan, which is new or empty")(
      "tiles", text("N"), "how many tiles (default: 16)")("tile-nodes", text("K"),
                                                          "or the nodes along the side of a tile")(
      "make", text("LIST")->default_value("vdb,ply"), "what is to be merged, a list of vdb, ply, obj, stl");
  if (!line.parse(arguments)) return kDone;
  const vdbtools::FractalOptions options = vdbtools::parseFractalOptions(line.recipe());
  vdbtools::TilePlanOptions tiles{.makes = parseMakes(line)};
  if (line.has("tiles") && line.has("tile-nodes"))
    throw std::invalid_argument("--tiles and --tile-nodes exclude each other");
  if (line.has("tile-nodes"))
    tiles.tileNodes = line.integer<int>("tile-nodes", 2, std::numeric_limits<int>::max() / 4);
  else
    tiles.tiles = line.has("tiles") ? line.integer<int>("tiles", 1, vdbtools::kMostTiles) : 16;
  const std::filesystem::path folder = newPlanFolder(line);
  const vdbtools::TilePlan plan = vdbtools::planTiles(options, line.recipe(), tiles, folder, line.progress());
  if (tiles.tiles && plan.manifest.tasks.size() < static_cast<std::size_t>(*tiles.tiles))
    report().text() << "note: " << plan.manifest.tasks.size() << " tiles are all that the blocks of 8 x 8 x 8 nodes "
                    << "with something to do can be cut into\n";
  return finishPlan(folder, plan.manifest);
}

}  // namespace cli
