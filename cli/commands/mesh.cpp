// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"
#include "sequence.h"
#include "shape_unit.h"

#include "vdbtools/decimation/adaptive_mesh.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/surface/level_set.h"

#include <optional>
#include <ostream>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kMeshUsage = {"mesh", "F.vdb -o F.ply [--from-grid] [options]",
                              "Makes a mesh from a VDB. If the VDB is a fractal that this program made, the vertices "
                              "lie on the true surface, which is computed again from the recipe in the file. With "
                              "--from-grid, and for any other level set, the voxels are used.",
                              "  juliavdb mesh bunny.vdb -o bunny.ply\n"
                              "  juliavdb mesh bunny.vdb -o same.ply --input bunny.obj\n"
                              "  juliavdb mesh bunny_sdf.vdb -o bunny.stl\n"
                              "  juliavdb mesh bunny.vdb -o blocky.obj --from-grid\n"
                              "  juliavdb mesh grow.####.vdb -o grow.####.ply --frames 1-2\n"};

/// The recipe in the VDB as it is recorded, and with the current paths of its files.
struct MeshRecipe {
  vdbtools::Recipe recorded, found;
};

/// Finds the recipe, with --input in place of the recorded target.
MeshRecipe recipeFor(const CommandLine& line, const std::string& vdb, const vdbtools::Recipe& recorded) {
  const char* const wayOut = ", the target itself with --input FILE, or use the voxels with --from-grid";
  if (!line.has("input")) return {recorded, withFoundFiles(line, recorded, vdb, wayOut)};
  const std::string input = line.text("input");
  if (!recorded.contains("input")) throw std::invalid_argument("the fractal in '" + vdb + "' has no target");
  const vdbtools::Recipe other = vdbtools::overridden(recorded, {{"input", input}}, vdbtools::fractalOptionTable());
  const auto hash = recorded.find("source-sha256");
  const bool isTheSame = hash == recorded.end() || vdbtools::sha256OfFile(input) == hash->second;
  if (!isTheSame)
    report().text() << "warning: '" << input << "' is not the target that the VDB was made of, '"
                    << recorded.at("input") << "'; the mesh is that of its fractal, and not that of the VDB\n";
  const vdbtools::Recipe found = withFoundFiles(line, other, vdb, wayOut);
  return {isTheSame ? recorded : other, found};
}

vdbtools::MeshCounts meshFromRecipe(const MeshRecipe& recipe, vdbtools::AtomicFile& file,
                                    const vdbtools::FileFormat& format, vdbtools::Monitor& progress) {
  const vdbtools::Scene scene = vdbtools::makeScene(vdbtools::parseFractalOptions(recipe.found), progress);
  return vdbtools::writeFractal(scene, recipe.recorded, {.files = {{&file, &format}}}, progress).mesh;
}

vdbtools::MeshCounts meshFromGrid(const std::string& input, const CommandLine& line, vdbtools::AtomicFile& file,
                                  const vdbtools::FileFormat& format, double adaptivity,
                                  std::optional<vdbtools::LengthUnit> unit, vdbtools::Monitor& progress) {
  const vdbtools::VdbFile vdb = vdbtools::readVdb(input);
  const auto levelSet = vdbtools::chooseFloatGrid(vdb, line.text("grid"), input);
  const vdbtools::FileAxes axes{
      .target = vdbtools::recordedUpAxis(vdb.metadata),
      .rule = line.has("up") ? vdbtools::parseUpRule(line.text("up")) : vdbtools::UpRule::Keep,
      .unit = unit};
  vdbtools::MeshWriteOptions options = vdbtools::meshWriteOptions(format, axes, {});
  vdbtools::Mesh mesh = vdbtools::meshOfLevelSet(*levelSet, progress);
  vdbtools::computeNormals(mesh);
  options.voxelSize = levelSet->voxelSize()[0];
  if (adaptivity > 0) {
    vdbtools::Mesh adapted;
    vdbtools::MeshCollector collector(adapted);
    vdbtools::AdaptiveMeshSink sink(collector, adaptivity * options.voxelSize);
    sink.addPoints({mesh.points, mesh.normals});
    sink.addTriangles(mesh.triangles, 0);
    sink.finish(progress);
    mesh = std::move(adapted);
  }
  progress.begin(vdbtools::PhaseKind::Writing, 0);
  vdbtools::writeMesh(file.stream(), mesh, options);
  return {mesh.points.size(), mesh.triangles.size()};
}

/// @param asked       the options of the command line about a fractal's surface
/// @param adaptivity  for a mesh made from voxels
FrameJob meshJob(const CommandLine& line, const std::string& input, const vdbtools::Recipe& asked, double adaptivity) {
  const std::optional<vdbtools::LengthUnit> unit = unitOf(line, input);
  vdbtools::RecordedRecipe recorded;
  if (!line.has("from-grid") && !line.has("grid")) recorded = vdbtools::readRecordedRecipe(input);
  const bool isFractal = recorded.command == "fractal";
  if (isFractal) {
    for (const auto& [name, value] : asked) recorded.recipe[name] = value;
    if (line.has("up")) recorded.recipe["up"] = line.text("up");
    if (line.has("units")) recorded.recipe["units"] = line.text("units");
  }
  line.requireUse(isFractal, {"input", "search"},
                  "it is for the files of a fractal's recipe, and here the voxels are used; leave it out");
  const MeshRecipe recipe = isFractal ? recipeFor(line, input, recorded.recipe) : MeshRecipe();
  FrameJob job;
  if (isFractal) job.inputs = vdbtools::inputsOf(vdbtools::parseFractalOptions(recipe.found));
  job.make = [&line, input, recipe, isFractal, adaptivity, unit](const FrameRun& run) {
    vdbtools::AtomicFile& file = run.outputs.add("output", line.text("output"), &vdbtools::FileFormat::writesMesh);
    const vdbtools::FileFormat& format = vdbtools::meshFormat(formatOf(line.text("output"), ".ply"));
    const vdbtools::MeshCounts counts = isFractal
                                            ? meshFromRecipe(recipe, file, format, run.monitor)
                                            : meshFromGrid(input, line, file, format, adaptivity, unit, run.monitor);
    run.monitor.throwIfCancelled();
    run.outputs.commit(run.isLast);
    report().count("points", counts.points);
    report().count("triangles", counts.triangles);
    report().text() << "wrote " << run.outputs.names() << ": " << counts.triangles << " triangles\n";
    if (isFractal)
      noteLeftOut(file.target(),
                  vdbtools::meshColumns(vdbtools::parseFractalOptions(recipe.recorded).output.attributes));
  };
  return job;
}

}  // namespace

int runMesh(const Arguments& arguments) {
  CommandLine line(kMeshUsage, vdbtools::OptionTable());
  line.addPositional("vdb", 1, "the VDB");
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.ply"), meshHelp().c_str())(
      "input", po::value<std::string>()->value_name("FILE"),
      "where the fractal's target is, if it is neither where the recipe says nor beside the VDB")(
      "from-grid", "use the voxels, even of a fractal")("grid", po::value<std::string>()->value_name("NAME"),
                                                        "which grid to use, with --from-grid")(
      "up", po::value<std::string>()->value_name("keep|y|z|auto"),
      "the axis that points up in the mesh, as of 'fractal' (default: as recorded in the VDB)");
  addUnitsOption(line);
  addSearchOption(line);
  addFramesOption(line);
  for (const vdbtools::OptionSpec& option : vdbtools::surfaceOptionSpecs())
    if (option.name == "adaptivity") line.addOptions({option});
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("vdb");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.ply");
  vdbtools::Recipe asked;
  if (line.has("adaptivity")) asked["adaptivity"] = line.text("adaptivity");
  const vdbtools::OptionTable table(vdbtools::surfaceOptionSpecs());
  const double adaptivity = vdbtools::parseSurfaceOptions(vdbtools::RecipeReader(asked, table)).adaptivity;
  return runFrames(line, input, kOnlyOutput,
                   [&](const std::string& name) { return meshJob(line, name, asked, adaptivity); });
}

}  // namespace cli
