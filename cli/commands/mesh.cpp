// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "adaptivity.h"
#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_files.h"
#include "vdbtools/job/recorded_recipe.h"
#include "vdbtools/mesh/adaptive_mesh.h"
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

vdbtools::MeshCounts fromRecipe(const vdbtools::Recipe& recipe, vdbtools::AtomicFile& file, vdbtools::MeshFormat format,
                                double adaptivity, Progress& progress) {
  const vdbtools::Scene scene = vdbtools::makeScene(vdbtools::parseFractalOptions(recipe), progress);
  return vdbtools::writeFractal(scene, recipe, {.meshes = {{&file, format}}, .adaptivity = adaptivity}, progress).mesh;
}

vdbtools::MeshCounts fromGrid(const std::string& input, const std::string& grid, vdbtools::AtomicFile& file,
                              vdbtools::MeshWriteOptions options, double adaptivity, Progress& progress) {
  const vdbtools::VdbFile vdb = vdbtools::readVdb(input);
  const auto levelSet = vdbtools::chooseFloatGrid(vdb, grid, input);
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
  progress.begin("writing", 0);
  vdbtools::writeMesh(file.stream(), mesh, options);
  return {mesh.points.size(), mesh.triangles.size()};
}

}  // namespace

int runMesh(const Arguments& arguments) {
  CommandLine line(kUsageText, vdbtools::OptionTable());
  line.addPositional("input", 1, "the VDB");
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.ply"), "the mesh to write: .ply, .obj or .stl")(
      "from-grid", "use the voxels, even of a fractal")("grid", po::value<std::string>()->value_name("NAME"),
                                                        "which grid to use, with --from-grid");
  addAdaptivity(line);
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.ply");
  const double adaptivity = parseAdaptivity(line);
  Outputs outputs;
  vdbtools::AtomicFile& file = outputs.add("output", line.text("output"), ".ply .obj .stl");

  vdbtools::RecordedRecipe recorded;
  if (!line.has("from-grid") && !line.has("grid")) recorded = vdbtools::readRecordedRecipe(input);
  const vdbtools::MeshWriteOptions options{.format =
                                               vdbtools::meshFormat("mesh" + formatOf(line.text("output"), ".ply"))};
  const vdbtools::MeshCounts counts =
      recorded.command == "fractal" ? fromRecipe(recorded.recipe, file, options.format, adaptivity, line.progress())
                                    : fromGrid(input, line.text("grid"), file, options, adaptivity, line.progress());
  line.progress().throwIfCancelled();
  outputs.commit();
  report().count("points", static_cast<double>(counts.points));
  report().count("triangles", static_cast<double>(counts.triangles));
  report().text() << "wrote " << outputs.names() << ": " << counts.triangles << " triangles\n";
  return kDone;
}

}  // namespace cli
