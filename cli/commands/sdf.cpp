// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "grid_file.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "sequence.h"
#include "target_text.h"

#include "vdbtools/base/text.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/sdf_job.h"

#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kSdfUsage = {
    "sdf", "MESH|SDF.vdb -o F.vdb|F.nvdb [--resolution N | --voxel-size H] [--repair] [options]",
    "Makes a signed distance field of a mesh: a narrow-band level set, negative inside. A "
    "mesh that leaks is refused; --repair closes it. --solidify makes a block of terrain, "
    "--thicken a plate of a sheet, and --points-radius a solid of a cloud of points. Of a VDB, "
    "it measures the distances to the surface of its level set anew, on the same voxels, in a "
    "band of any width; of a fog volume, or with --iso of any other grid, it makes a level set.",
    "  juliavdb sdf bunny.obj -o bunny_sdf.vdb --resolution 200\n"
    "  juliavdb sdf scan.ply -o scan_sdf.vdb --voxel-size 0.01 --repair\n"
    "  juliavdb sdf bunny_sdf.vdb -o wide.vdb --band 30\n"
    "  juliavdb sdf walk.####.obj -o walk.####.vdb --frames 1-2 --resolution 60\n"};

/// Writes the distances of one mesh. @param recipe  the recipe to record
void writeSdf(const CommandLine& line, const vdbtools::Recipe& recipe, const FrameRun& run) {
  const vdbtools::SdfOptions options = vdbtools::parseSdfOptions(recipe);
  const GridOutput output = gridOutput(line);
  std::ostream& file = run.outputs.add("output", line.text("output"), &vdbtools::FileFormat::writesGrids).stream();

  vdbtools::SdfResult result = vdbtools::runSdf(options, run.monitor);
  std::map<std::string, std::string> metadata = vdbtools::recipeToMetadata(recipe, "sdf");
  metadata.insert(result.metadata.begin(), result.metadata.end());
  vdbtools::VdbWriteOptions write = vdbtools::vdbWriteOptions(options.axes, std::move(metadata));
  write.half = options.half;
  write.names = options.gridNames;
  std::vector<vdbtools::ClampedGrid> clamped;
  write.clamped = &clamped;
  run.monitor.begin(vdbtools::PhaseKind::Writing, 0);
  const std::vector<vdbtools::NvdbWritten> written =
      vdbtools::writeGrids(file, *output.format, {result.grid}, write, output.values);
  run.monitor.throwIfCancelled();
  run.outputs.commit(run.isLast);
  report().count("voxels", result.grid->activeVoxelCount());
  report().count("voxelSize", result.grid->voxelSize()[0]);
  report().text() << "wrote " << run.outputs.names() << ": " << result.grid->activeVoxelCount() << " voxels of "
                  << vdbtools::shortText(result.grid->voxelSize()[0]) << '\n';
  tellNvdb(written);
  tellClamped(clamped);
  if (result.caps > 0)
    report().text() << "repaired: " << result.caps << (result.caps == 1 ? " hole" : " holes") << " of up to "
                    << vdbtools::shortText(*result.closedGap, vdbtools::Rounding::Up)
                    << " capped, the surface moved by at most "
                    << vdbtools::shortText(*result.moved, vdbtools::Rounding::Up) << '\n';
  else if (result.moved)
    report().text() << "repaired: gaps up to " << vdbtools::shortText(*result.closedGap, vdbtools::Rounding::Up)
                    << " closed, the surface moved by at most "
                    << vdbtools::shortText(*result.moved, vdbtools::Rounding::Up) << '\n';
  tellTarget(result.metadata);
}

}  // namespace

int runSdf(const Arguments& arguments) {
  CommandLine line(kSdfUsage, vdbtools::sdfOptionTable());
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.vdb"), gridsHelp().c_str())(
      "frame", po::value<std::string>()->value_name("N"), "the frame number, for names such as name.####.vdb");
  addNvdbOption(line);
  addFramesOption(line);
  line.acceptStandardInput();
  if (!line.parse(arguments)) return kDone;
  const vdbtools::SdfOptions options = vdbtools::parseSdfOptions(line.recipe());
  line.requireEffect({vdbtools::Product::Vdb});
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.vdb");
  gridOutput(line);
  return runFrames(line, options.input, kOnlyOutput, [&](const std::string& input) {
    vdbtools::Recipe recipe = line.recipe();
    recipe["input"] = input;
    vdbtools::InputFiles inputs;
    inputs.add(input);
    return FrameJob{inputs, [&line, recipe](const FrameRun& run) { writeSdf(line, recipe, run); }};
  });
}

}  // namespace cli
