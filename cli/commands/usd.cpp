// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"

#include "vdbtools/farm/frame_plan.h"
#include "vdbtools/files/frame_name.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/usd/usd_job.h"

#include <ostream>
#include <stdexcept>
#include <utility>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kUsdUsage = {
    "usd", "[F.vdb | F.####.vdb --frames A-B] [--mesh F.ply] -o F.usda [options]",
    "Writes a scene of USD (.usda) beside files that were made before: a Volume that refers to the grids of a VDB, or "
    "of one VDB for each frame, by relative paths, and a mesh, which is part of the scene.",
    "  juliavdb usd bunny.vdb -o bunny.usda --mesh bunny.ply\n"
    "  juliavdb usd grow.####.vdb --frames 1-48 -o grow.usda\n"};

}  // namespace

int runUsd(const Arguments& arguments) {
  CommandLine line(kUsdUsage, vdbtools::OptionTable());
  line.addPositional("input", 1, "the VDB, or the name of a sequence");
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("F.usda"), "the scene to write")(
      "mesh", text("F.ply"), "a mesh to put into the scene")("frames", text("A-B"),
                                                             "the frames of a sequence, such as 1-48 or 1-48x2")(
      "fps", text("N")->default_value("24"), "frames a second")("meters-per-unit", text("M"),
                                                                "the length of a unit of the files, in metres, where "
                                                                "it is none of those of --units (default: that of "
                                                                "their unit, or else 1)")(
      "units", text("mm|cm|m|in"), "the unit of files that do not name their own");
  if (!line.parse(arguments)) return kDone;
  vdbtools::UsdOptions options{.vdb = line.text("input"), .framesPerSecond = line.number("fps")};
  if (options.vdb.empty() && !line.has("mesh"))
    throw std::invalid_argument("nothing was given for the scene; name a VDB, --mesh F.ply, or both");
  if (line.has("meters-per-unit")) {
    options.metersPerUnit = line.number("meters-per-unit");
    if (!(*options.metersPerUnit > 0)) line.refuse("meters-per-unit", "above 0");
    line.requireUse(false, {"units"}, "--meters-per-unit says the same; leave one of them out");
  }
  if (line.has("units")) options.unit = vdbtools::parseLengthUnit(line.text("units"));
  if (!(options.framesPerSecond > 0)) line.refuse("fps", "above 0");
  if (line.has("mesh")) options.mesh = line.text("mesh");
  if (line.has("frames")) options.frames = vdbtools::farm::parseFrames(line.text("frames"));
  line.requireUse(line.has("frames"), {"fps"}, "it is for a sequence; give --frames too, or leave it out");
  line.requireUse(!options.vdb.empty(), {"frames"}, "it is for a sequence of VDBs, and none is given; leave it out");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.usda");
  vdbtools::InputFiles inputs;
  if (options.mesh) inputs.add(*options.mesh);
  if (!options.vdb.empty())
    for (const int frame : options.frames) inputs.add(vdbtools::expandFrame(options.vdb, frame));
  Outputs outputs(line, std::move(inputs));
  std::ostream& file = outputs.add("output", line.text("output"), ".usda").stream();
  options.scene = line.text("output");
  const vdbtools::UsdCounts counts = vdbtools::writeUsdScene(file, options, line.progress());
  outputs.commit();
  report().count("frames", counts.frames);
  report().count("triangles", counts.triangles);
  report().text() << "wrote " << outputs.names() << ": ";
  if (counts.frames > 0)
    report().text() << counts.fields << (counts.fields == 1 ? " grid" : " grids") << " of " << counts.frames
                    << (counts.frames == 1 ? " VDB" : " VDBs");
  if (counts.triangles > 0) report().text() << (counts.frames > 0 ? ", " : "") << counts.triangles << " triangles";
  report().text() << '\n';
  return kDone;
}

}  // namespace cli
