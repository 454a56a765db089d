// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "sequence.h"

#include "vdbtools/files/frames.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/usd/usd_job.h"

#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace cli {
namespace {

constexpr Usage kUsdUsage = {
    "usd", "[F.vdb] [--mesh F.ply] [--frames LIST] -o F.usda|--package F.usdz [options]",
    "Writes a scene of USD: a Volume that refers to the grids of a VDB by a relative path, and a mesh, which is part "
    "of "
    "the scene. With --frames, names such as F.####.vdb and F.####.ply are another file in each frame, and what has no "
    "place for the frame stays as it is. A package holds meshes, and no VDB: USD allows none there.",
    "  juliavdb usd bunny.vdb -o bunny.usda --mesh bunny.ply\n"
    "  juliavdb usd grow.####.vdb --frames 1-3 -o grow.usda\n"
    "  juliavdb usd --mesh grow.####.ply --frames 1-3 --package grow.usdz\n"};

std::vector<vdbtools::OptionSpec> usdOptionSpecs() {
  return {
      {.name = "output", .argument = "F.usda", .help = "the scene to write"},
      {.name = "package",
       .argument = "F.usdz",
       .help = "the scene as one file, as phones and web pages take it; it holds meshes only"},
      {.name = "mesh", .argument = "F.ply", .help = "a mesh to put into the scene"},
      {.name = "frames", .argument = "LIST", .help = kFramesHelp},
      {.name = "fps",
       .argument = "N",
       .defaultValue = vdbtools::numbersText({vdbtools::UsdOptions().framesPerSecond}),
       .help = "frames a second"},
      {.name = "meters-per-unit",
       .argument = "M",
       .help = "the length of a unit of the files, in metres, where it is none of those of --units",
       .defaultNote = "that of their unit, or else 1",
       .alternative = "units"},
      {.name = "units",
       .argument = "mm|cm|m|in",
       .help = "the unit of files that do not name their own",
       .alternative = "meters-per-unit"},
  };
}

constexpr const char* kUsdInputs[] = {"input", "mesh"};

/// The files of the scene. @throw vdbtools::MissingInputError  the file of a frame is missing
vdbtools::InputFiles usdInputs(const CommandLine& line, const std::vector<int>& frames) {
  vdbtools::FrameInputs inputs;
  vdbtools::InputFiles others;
  for (const char* name : kUsdInputs) {
    const std::string text = line.text(name);
    if (text.empty()) continue;
    if (!vdbtools::hasFramePattern(text))
      others.add(text);
    else
      for (const int frame : frames) inputs.add(vdbtools::expandFrame(text, frame), frame);
  }
  inputs.requireNoneMissing();
  others.add(inputs.files());
  return others;
}

std::string countText(std::size_t count, const char* one, const char* several) {
  return std::to_string(count) + ' ' + (count == 1 ? one : several);
}

}  // namespace

int runUsd(const Arguments& arguments) {
  CommandLine line(kUsdUsage, vdbtools::OptionTable());
  line.addPositional("input", 1, "the VDB, or the name of a sequence");
  line.addOptions(usdOptionSpecs());
  if (!line.parse(arguments)) return kDone;
  const vdbtools::OptionTable table(usdOptionSpecs());
  const vdbtools::RecipeReader reader(line.given(table), table);
  vdbtools::UsdOptions options{.vdb = line.text("input"),
                               .mesh = reader.text("mesh"),
                               .frames = framesOf(line, {}),
                               .framesPerSecond = reader.number("fps")};
  if (options.vdb.empty() && options.mesh.empty())
    throw std::invalid_argument("nothing was given for the scene; name a VDB, --mesh F.ply, or both");
  if (reader.has("meters-per-unit")) {
    options.metersPerUnit = reader.positive("meters-per-unit");
    line.requireUse(false, {"units"}, "--meters-per-unit says the same; leave one of them out");
  }
  if (reader.has("units")) options.unit = vdbtools::parseLengthUnit(reader.text("units"));
  if (!(options.framesPerSecond > 0)) reader.refuse("fps", "above 0");
  line.requireUse(line.has("frames"), {"fps"}, "it is for a sequence; give --frames too, or leave it out");
  if (!line.has("output") && !line.has("package"))
    throw std::invalid_argument("no output was given; use -o F.usda, --package F.usdz, or both");
  if (line.has("package") && !options.vdb.empty())
    throw std::invalid_argument("--package is '" + line.text("package") +
                                "', and the specification of .usdz allows no " +
                                "VDB in it; write -o F.usda beside the VDB, or package --mesh alone");
  Outputs outputs(line, usdInputs(line, options.frames));
  vdbtools::UsdOutputs written;
  if (line.has("output")) written.scene = &outputs.add("output", line.text("output"), ".usda").stream();
  if (line.has("package")) {
    written.package = &outputs.add("package", line.text("package"), ".usdz").stream();
    written.packageName = std::filesystem::path(line.text("package")).stem().string() + ".usda";
  }
  options.scene = line.text("output");
  const vdbtools::UsdCounts counts = vdbtools::writeUsdScene(written, options, line.progress());
  outputs.commit();
  report().count("frames", counts.frames);
  report().count("meshes", counts.meshes);
  report().count("triangles", counts.triangles);
  report().text() << "wrote " << outputs.names() << ": ";
  if (counts.frames > 0)
    report().text() << countText(counts.fields, "grid", "grids") << " of " << countText(counts.frames, "VDB", "VDBs");
  if (counts.meshes > 0)
    report().text() << (counts.frames > 0 ? ", " : "") << counts.triangles << " triangles"
                    << (counts.meshes > 1 ? " of " + countText(counts.meshes, "mesh", "meshes") : "");
  report().text() << '\n';
  return kDone;
}

}  // namespace cli
