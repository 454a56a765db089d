// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include "child_process.h"
#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "target_text.h"

#include "vdbtools/farm/estimate.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/fractal_options.h"

#include <cstdlib>
#include <limits>
#include <optional>
#include <ostream>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kPlanTilesUsage = {
    "plan tiles", "MESH|SDF.vdb -o DIR [--tiles N | --tile-nodes K] [--make LIST] [options of fractal]",
    "Cuts one fractal into tiles, boxes of lattice nodes. Any number of machines make them, and 'juliavdb merge' puts "
    "them together into the files that one run would have made, byte for byte. The distances and the exponent are made "
    "once, here, and the tasks read them.\n\n"
    "--tiles cuts the lattice into tiles of about equal work. --tile-nodes cuts it into cubes and leaves out those in "
    "which there is nothing to do.\n\n"
    "--estimate makes some tiles at random, which then are done, and tells from them what all of them will take, with "
    "the 95 % interval of each number.",
    "  juliavdb plan tiles bunny.obj -o farm --tiles 16 --resolution 150\n"
    "  juliavdb plan tiles bunny.obj -o cubes --tile-nodes 64 --make ply --resolution 150 --detail 0.4\n"
    "  juliavdb plan tiles bunny.obj -o large --tiles 500 --make ply --resolution 3200 --estimate\n",
    "fractal"};

/// A number with its unit, three digits.
std::string amount(double value, std::initializer_list<std::pair<double, const char*>> units) {
  for (const auto& [size, name] : units)
    if (value >= size || size == (units.end() - 1)->first) {
      char text[48];
      std::snprintf(text, sizeof text, "%.3g%s", value / size, name);
      return text;
    }
  return "";
}

void tellEstimate(const char* what, const char* name, const vdbtools::farm::Estimated& estimated,
                  std::initializer_list<std::pair<double, const char*>> units) {
  report().count(name, estimated.value);
  report().count(name + std::string("Low"), estimated.low);
  report().count(name + std::string("High"), estimated.high);
  report().text() << what << amount(estimated.value, units) << " (" << amount(estimated.low, units) << " to "
                  << amount(estimated.high, units) << ")\n";
}

/// Runs some of the tasks, each as a process of its own, as a farm would.
std::vector<vdbtools::farm::SampledTask> makeSample(const CommandLine& line, const std::filesystem::path& folder,
                                                    const vdbtools::farm::TilePlan& plan, std::uint64_t count) {
  constexpr std::uint64_t kSeed = 1;
  // Read it again, because only the written manifest has its hash.
  const vdbtools::farm::Manifest manifest = vdbtools::farm::readManifest(folder);
  const std::vector<std::uint64_t> indices = vdbtools::farm::sampleTasks(manifest.tasks.size(), count, kSeed);
  vdbtools::Monitor& monitor = line.progress();
  monitor.begin(vdbtools::PhaseKind::Sample, indices.size());
  std::vector<vdbtools::farm::SampledTask> sample;
  for (const std::uint64_t index : indices) {
    std::vector<std::string> words = {"task", folder.string(), "--index", std::to_string(index), "--progress", "none"};
    if (line.has("threads")) words.insert(words.end(), {"--threads", line.text("threads")});
    if (line.has("trust-importer")) words.emplace_back("--trust-importer");
    const int code = runThisProgram(words, [&] { return monitor.cancelled(); });
    monitor.throwIfCancelled();
    const std::optional<vdbtools::farm::TaskRecord> record =
        vdbtools::farm::finishedTask(folder, manifest, index, vdbtools::farm::FileCheck::Quick);
    if (!record)
      throw vdbtools::DataError(
          "task " + std::to_string(index) + " of the sample failed with exit code " + std::to_string(code) + ": " +
          vdbtools::farm::taskStatus(folder, manifest, index, vdbtools::farm::FileCheck::Quick).error);
    sample.push_back({plan.work[index - 1], *record});
    monitor.advance(1);
  }
  return sample;
}

void tellEstimate(const vdbtools::farm::PlanEstimate& estimate) {
  report().text() << "from " << estimate.sampled << " of " << estimate.tasks
                  << " tiles, which are done now, with 95 % intervals:\n";
  tellEstimate("  triangles         ", "estimatedTriangles", estimate.triangles,
               {{1e12, " trillion"}, {1e9, " billion"}, {1e6, " million"}, {1e3, " thousand"}, {1, ""}});
  tellEstimate("  CPU time          ", "estimatedCpuSeconds", estimate.cpuSeconds,
               {{3600, " h"}, {60, " min"}, {1, " s"}});
  tellEstimate("  memory of a task  ", "estimatedPeakBytes", estimate.peakBytes, {{0x1p30, " GiB"}, {0x1p20, " MiB"}});
  tellEstimate("  disk              ", "estimatedDiskBytes", estimate.diskBytes,
               {{0x1p40, " TiB"}, {0x1p30, " GiB"}, {0x1p20, " MiB"}, {0x1p10, " KiB"}});
}

}  // namespace

int runPlanTiles(const Arguments& arguments) {
  CommandLine line(kPlanTilesUsage, vdbtools::fractalOptionTable());
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("DIR"), "the folder of the plan, which is new or empty")(
      "tiles", text("N"), "how many tiles (default: 16)")("tile-nodes", text("K"),
                                                          "or the nodes along the side of a tile")(
      "make", text("LIST")->default_value("vdb,ply"),
      ("what is to be merged, a list of " + vdbtools::joined(vdbtools::writtenFormats()) +
       "; or count, to make and count the triangles without keeping them")
          .c_str())("estimate", po::bool_switch(),
                    "makes a random sample of the tiles and tells what all of them will take")(
      "sample", text("M")->default_value("24"), "how many tiles --estimate makes");
  if (!line.parse(arguments)) return kDone;
  const vdbtools::FractalOptions options = vdbtools::parseFractalOptions(line.recipe());
  vdbtools::farm::TilePlanOptions tiles{.makes = parseMakes(line)};
  if (line.has("tiles") && line.has("tile-nodes"))
    throw std::invalid_argument("--tiles and --tile-nodes exclude each other");
  if (line.has("tile-nodes"))
    tiles.tileNodes = line.integer<int>("tile-nodes", 2, std::numeric_limits<int>::max() / 4);
  else
    tiles.tiles = line.has("tiles") ? line.integer<int>("tiles", 1, vdbtools::farm::kMostTiles) : 16;
  const bool wantsEstimate = line.values()["estimate"].as<bool>();
  const auto sampleSize = line.integer<std::uint64_t>("sample", 2, vdbtools::farm::kMostTiles);
  tiles.survey = wantsEstimate;
  line.requireUse(wantsEstimate, {"sample"}, "it goes with --estimate; give that too, or leave it out");
  line.requireEffect(productsOf(tiles.makes));
  const std::filesystem::path folder = newPlanFolder(line);
  const vdbtools::farm::TilePlan plan =
      vdbtools::farm::planTiles(options, line.recipe(), tiles, folder, line.progress());
  if (tiles.tiles && plan.manifest.tasks.size() < static_cast<std::size_t>(*tiles.tiles))
    report().text() << "note: " << plan.manifest.tasks.size() << " tiles are all that the blocks of 8 x 8 x 8 nodes "
                    << "with something to do can be cut into\n";
  if (!plan.chosenResolution.empty()) report().text() << plan.chosenResolution << '\n';
  if (!plan.finerThanVoxels.empty()) report().text() << "warning: " << plan.finerThanVoxels << '\n';
  tellTarget(plan.manifest.metadata);
  const int code = finishPlan(folder, plan.manifest);
  if (wantsEstimate) tellEstimate(vdbtools::farm::estimatePlan(plan.work, makeSample(line, folder, plan, sampleSize)));
  return code;
}

}  // namespace cli
