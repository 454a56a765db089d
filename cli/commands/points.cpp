// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"
#include "sequence.h"
#include "shape_unit.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/points_job.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/attribute_options.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/surface/level_set.h"

#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace cli {
namespace {

constexpr Usage kPointsUsage = {
    "points", "F.vdb|MESH -o P.ply|P.vdb (--points N | --spacing S) [options]",
    "Spreads oriented points over a surface as blue noise, and writes them as a PLY without faces or as OpenVDB "
    "points. If the input is a fractal that this program made, VDB, PLY or OBJ, they lie on the true surface, which is "
    "computed again from the recipe in the file. With --from-grid the voxels or triangles themselves are used, as they "
    "are of any other level set or mesh.",
    "  juliavdb points bunny.vdb -o bunny_points.ply --points 20000\n"
    "  juliavdb points bunny.vdb -o bunny_points.vdb --spacing 0.02\n"
    "  juliavdb points bunny.obj -o even.ply --spacing 0.05 --seed 7\n"
    "  juliavdb points grow.####.vdb -o points.####.ply --points 2000 --frames 1-2\n"};

std::vector<vdbtools::OptionSpec> pointsOptionSpecs() {
  return {
      {.name = "output",
       .argument = "P.ply",
       .help = "the points to write: " + vdbtools::extensionsOf(&vdbtools::FileFormat::points)},
      {.name = "points", .argument = "N", .help = "how many points, exactly", .alternative = "spacing"},
      {.name = "spacing",
       .argument = "S",
       .help = "the least distance between two points, in the units of the input",
       .alternative = "points"},
      {.name = "seed",
       .argument = "N",
       .defaultValue = std::to_string(vdbtools::PointsOptions().seed),
       .help = "another number gives other points"},
      {.name = "from-grid", .help = "use the voxels or triangles, even of a fractal"},
      {.name = "grid", .argument = "NAME", .help = "which grid of a VDB to use, as with --from-grid"},
  };
}

vdbtools::PointsOptions parsePoints(const CommandLine& line) {
  static const vdbtools::OptionTable table(pointsOptionSpecs());
  const vdbtools::RecipeReader reader(line.given(table), table);
  vdbtools::PointsOptions options;
  if (reader.has("points") == reader.has("spacing"))
    throw std::invalid_argument("give either --points N or --spacing S");
  if (reader.has("points"))
    options.count = reader.integer<std::uint64_t>("points", 1, std::uint64_t{1} << 25);
  else
    options.spacing = reader.number("spacing");
  if (options.spacing && !(*options.spacing > 0 && std::isfinite(*options.spacing)))
    reader.refuse("spacing", "a length above 0, in the units of the input");
  options.seed = reader.integer<std::uint64_t>("seed", 0, std::numeric_limits<std::uint64_t>::max());
  return options;
}

struct Made {
  vdbtools::OrientedPoints points;
  std::map<std::string, std::string> metadata;
  double voxelSize = 0;  ///< of a fractal, world units
  vdbtools::FileAxes axes{};
};

/// The options that choose the attributes of the points. For a fractal, they replace the same options of its recipe.
const vdbtools::OptionTable& attributeTable() {
  static const vdbtools::OptionTable table(vdbtools::attributeOptionSpecs());
  return table;
}

Made pointsFromRecipe(const vdbtools::Recipe& recipe, const vdbtools::FractalOptions& fractal,
                      const vdbtools::PointsOptions& options, vdbtools::Monitor& progress) {
  const vdbtools::Scene scene = vdbtools::makeScene(fractal, progress);
  return {vdbtools::fractalPoints(scene, options, progress), vdbtools::sceneMetadata(scene, recipe), scene.voxelSize,
          scene.options.output.axes};
}

Made pointsFromShape(const std::string& input, const std::string& grid, const vdbtools::PointsOptions& options,
                     vdbtools::Monitor& progress) {
  if (!vdbtools::isVdbPath(input)) {
    return {vdbtools::meshPoints(vdbtools::readMesh(input), options, progress), {}, 0};
  }
  const vdbtools::VdbFile vdb = vdbtools::readVdb(input);
  const auto levelSet = vdbtools::chooseFloatGrid(vdb, grid, input);
  return {vdbtools::meshPoints(vdbtools::meshOfLevelSet(*levelSet, progress), options, progress), {}, 0};
}

void writePoints(const CommandLine& line, const Made& made, const FrameRun& run, vdbtools::AtomicFile& file) {
  const vdbtools::OrientedPoints& points = made.points;
  run.monitor.begin(vdbtools::PhaseKind::Writing, 0);
  if (vdbtools::isVdbPath(line.text("output"))) {
    const double spacing = points.spacing > 0 ? points.spacing : points.reach > 0 ? points.reach : 1;
    // The points themselves are rotated, because the transform of a grid would not rotate normals.
    vdbtools::VdbWriteOptions write = vdbtools::vdbWriteOptions(made.axes, made.metadata);
    vdbtools::OrientedPoints turned = points;
    for (openvdb::Vec3d& position : turned.positions) position = write.turn(position);
    for (openvdb::Vec3s& normal : turned.normals) normal = write.turn(normal);
    vdbtools::turnWorldVectors(turned.values, turned.columns, write.turn);
    write.turn = {};
    file.stream() << vdbtools::encodeVdb({vdbtools::pointGrid(turned.batch(), turned.columns, spacing)}, write);
  } else {
    vdbtools::MeshWriteOptions write =
        vdbtools::meshWriteOptions(vdbtools::meshFormat(".ply"), made.axes, made.metadata);
    write.voxelSize = points.spacing;
    write.columns = points.columns;
    // A PLY of points contains no recipe, only the unit.
    std::erase_if(write.comments, [](const auto& entry) { return entry.first != vdbtools::kLengthUnit; });
    vdbtools::writeMesh(file.stream(), {.points = points.positions, .triangles = {}, .normals = points.normals}, write,
                        points.values);
  }
  run.monitor.throwIfCancelled();
  run.outputs.commit(run.isLast);

  report().count("points", points.positions.size());
  report().count("spacing", points.spacing);
  report().count("reach", points.reach);
  report().count("lost", points.lost);
  report().text() << "wrote " << run.outputs.names() << ": " << points.positions.size()
                  << (points.positions.size() == 1 ? " point" : " points") << ", no two of them nearer than "
                  << vdbtools::shortText(points.spacing, vdbtools::Rounding::Down)
                  << ", the surface nowhere found farther than "
                  << vdbtools::shortText(points.reach, vdbtools::Rounding::Up) << " from one of them\n";
  if (points.lost > 0)
    report().text() << "note: " << points.lost
                    << " places were left out, as the true surface lies farther than a voxel ("
                    << vdbtools::shortText(made.voxelSize)
                    << ") from the mesh there; a higher --resolution of the fractal has fewer of them\n";
}

FrameJob pointsJob(const CommandLine& line, const std::string& input, const vdbtools::PointsOptions& options) {
  line.requireUse(vdbtools::isVdbPath(input), {"grid"},
                  "it chooses a grid of a VDB, and the input is a mesh; leave it out");
  const std::optional<vdbtools::LengthUnit> unit = unitOf(line, input);
  vdbtools::RecordedRecipe recorded;
  if (!line.has("from-grid") && !line.has("grid"))
    if (const vdbtools::FileFormat* const format = vdbtools::formatOfInput(input); format && format->isMadeAgain())
      recorded = vdbtools::readRecordedRecipe(input);
  const vdbtools::Recipe asked = line.given(attributeTable());
  if (recorded.command != "fractal" && !asked.empty())
    throw std::invalid_argument("--" + asked.begin()->first + " is for a fractal with its recipe; points of '" + input +
                                "' carry what the mesh has at its points");
  line.requireUse(recorded.command == "fractal", {"search"},
                  "it is for the files of a fractal's recipe, and none is read here; leave it out");
  vdbtools::Recipe recipe;
  std::optional<vdbtools::FractalOptions> fractal;
  if (recorded.command == "fractal") {
    recipe = withFoundFiles(line, recorded.recipe, input);
    for (const auto& [name, value] : asked) recipe[name] = value;
    if (line.has("units")) recipe["units"] = line.text("units");
    fractal = vdbtools::parseFractalOptions(recipe);
  }
  FrameJob job;
  if (fractal) job.inputs = vdbtools::inputsOf(*fractal);
  job.make = [&line, &options, input, recipe, fractal, unit](const FrameRun& run) {
    vdbtools::AtomicFile& file = run.outputs.add("output", line.text("output"), &vdbtools::FileFormat::points);
    Made made = fractal ? pointsFromRecipe(recipe, *fractal, options, run.monitor)
                        : pointsFromShape(input, line.text("grid"), options, run.monitor);
    if (!fractal) made.axes.unit = unit;
    writePoints(line, made, run, file);
  };
  return job;
}

}  // namespace

int runPoints(const Arguments& arguments) {
  CommandLine line(kPointsUsage, vdbtools::OptionTable());
  line.addPositional("input", 1, "the VDB or the mesh");
  line.addOptions(pointsOptionSpecs());
  line.addOptions(vdbtools::attributeOptionSpecs());
  addUnitsOption(line);
  addSearchOption(line);
  addFramesOption(line);
  line.acceptStandardInput();
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB or mesh was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o P.ply");
  const vdbtools::PointsOptions options = parsePoints(line);
  return runFrames(line, input, kOnlyOutput, [&](const std::string& name) { return pointsJob(line, name, options); });
}

}  // namespace cli
