// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_files.h"
#include "vdbtools/job/recorded_recipe.h"
#include "vdbtools/mesh/mesh_writer.h"
#include "vdbtools/surface/grid_mesh.h"

#include <ostream>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kUsageText = {"mesh", "F.vdb -o F.ply [--from-grid] [options]",
                              "Makes a mesh from a VDB. If the VDB is a fractal that this program made, the vertices "
                              "lie on the true surface, which\n"
                              "is computed again from the recipe in the file. With --from-grid, and for any other "
                              "level set, the voxels are used.",
                              "  juliavdb mesh bunny.vdb -o bunny.ply\n"
                              "  juliavdb mesh bunny_sdf.vdb -o bunny.stl\n"
                              "  juliavdb mesh bunny.vdb -o blocky.obj --from-grid\n"};

vdbtools::MeshCounts fromRecipe(vdbtools::Recipe recipe, const CommandLine& line, vdbtools::AtomicFile& file,
                                vdbtools::MeshFormat format, Progress& progress) {
  if (line.has("up")) recipe["up"] = line.text("up");
  const vdbtools::Scene scene = vdbtools::makeScene(vdbtools::parseFractalOptions(recipe), progress);
  return vdbtools::writeFractal(scene, recipe, {.meshes = {{&file, format}}}, progress).mesh;
}

vdbtools::MeshCounts fromGrid(const std::string& input, const CommandLine& line, vdbtools::AtomicFile& file,
                              vdbtools::MeshFormat format, Progress& progress) {
  const vdbtools::VdbFile vdb = vdbtools::readVdb(input);
  const auto levelSet = vdbtools::chooseFloatGrid(vdb, line.text("grid"), input);
  const vdbtools::FileAxes axes{
      .target = vdbtools::recordedUpAxis(vdb.metadata),
      .rule = line.has("up") ? vdbtools::parseUpRule(line.text("up")) : vdbtools::UpRule::Keep};
  vdbtools::MeshWriteOptions options = vdbtools::meshWriteOptions(format, axes, {});
  vdbtools::Mesh mesh = vdbtools::meshOfLevelSet(*levelSet, progress);
  vdbtools::computeNormals(mesh);
  options.voxelSize = levelSet->voxelSize()[0];
  progress.begin("writing", 0);
  vdbtools::writeMesh(file.stream(), mesh, options);
  return {mesh.points.size(), mesh.triangles.size()};
}

}  // namespace

int runMesh(const Arguments& arguments) {
  CommandLine line(kUsageText, vdbtools::OptionTable());
  line.addPositional("input", 1, "the VDB");
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.ply"), kMeshHelp)(
      "from-grid", "use the voxels, even of a fractal")("grid", po::value<std::string>()->value_name("NAME"),
                                                        "which grid to use, with --from-grid")(
      "up", po::value<std::string>()->value_name("keep|y|z|auto"),
      "the axis that points up in the mesh, as of 'fractal' (default: as recorded in the VDB)");
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.ply");
  Outputs outputs;
  vdbtools::AtomicFile& file = outputs.add("output", line.text("output"), vdbtools::kMeshExtensions);

  vdbtools::RecordedRecipe recorded;
  if (!line.has("from-grid") && !line.has("grid")) recorded = vdbtools::readRecordedRecipe(input);
  const vdbtools::MeshFormat format = vdbtools::meshFormat("mesh" + formatOf(line.text("output"), ".ply"));
  const vdbtools::MeshCounts counts = recorded.command == "fractal"
                                          ? fromRecipe(recorded.recipe, line, file, format, line.progress())
                                          : fromGrid(input, line, file, format, line.progress());
  line.progress().throwIfCancelled();
  outputs.commit();
  report().count("points", static_cast<double>(counts.points));
  report().count("triangles", static_cast<double>(counts.triangles));
  report().text() << "wrote " << outputs.names() << ": " << counts.triangles << " triangles\n";
  return kDone;
}

}  // namespace cli
