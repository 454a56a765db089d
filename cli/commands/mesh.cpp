// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"

#include "vdbtools/fractal_job.h"
#include "vdbtools/grid_mesh.h"
#include "vdbtools/mesh_writer.h"
#include "vdbtools/vdb_file.h"

#include <iostream>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kUsageText = {"mesh", "F.vdb -o F.ply [--from-grid] [options]",
                              "Makes a mesh of a VDB. Of a fractal that this program made, the vertices lie on the "
                              "true surface, which the recipe in\n"
                              "the file gives; --from-grid takes the voxels instead, as does any other level set.",
                              "  juliavdb mesh bunny.vdb -o bunny.ply\n"
                              "  juliavdb mesh bunny_sdf.vdb -o bunny.stl\n"
                              "  juliavdb mesh bunny.vdb -o blocky.obj --from-grid\n"};

struct Made {
  vdbtools::Mesh mesh;
  vdbtools::MeshWriteOptions write;
};

Made fromRecipe(const vdbtools::Recipe& recipe, Progress& progress) {
  const vdbtools::Scene scene = vdbtools::makeScene(vdbtools::parseFractalOptions(recipe), progress);
  Made made;
  made.mesh = vdbtools::runFractal(scene, false, true, progress).mesh;
  made.write.voxelSize = scene.voxelSize;
  made.write.comments = vdbtools::recipeToMetadata(recipe, "fractal");
  made.write.comments.insert(scene.facts.begin(), scene.facts.end());
  return made;
}

Made fromGrid(const std::string& input, const std::string& grid, Progress& progress) {
  const vdbtools::VdbFile file = vdbtools::readVdb(input);
  const auto levelSet = vdbtools::chooseFloatGrid(file, grid, input);
  Made made;
  made.mesh = vdbtools::meshOfLevelSet(*levelSet, progress);
  vdbtools::computeNormals(made.mesh);
  made.write.voxelSize = levelSet->voxelSize()[0];
  return made;
}

}  // namespace

int runMesh(const Arguments& arguments) {
  CommandLine line(kUsageText, {});
  line.addPositional("input", 1, "the VDB");
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.ply"), "the mesh to write: .ply, .obj or .stl")(
      "from-grid", "mesh the voxels, also of a fractal")("grid", po::value<std::string>()->value_name("NAME"),
                                                         "which grid; with --from-grid");
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.ply");
  Outputs outputs;
  std::ostream& file = outputs.add("output", line.text("output"), ".ply .obj .stl");

  const auto [recipe, command] = vdbtools::recipeFromMetadata(vdbtools::readVdbMetadata(input));
  const bool exact = command == "fractal" && !line.has("from-grid") && !line.has("grid");
  Made made = exact ? fromRecipe(recipe, line.progress()) : fromGrid(input, line.text("grid"), line.progress());
  made.write.format = vdbtools::meshFormat("mesh" + formatOf(line.text("output"), ".ply"));
  vdbtools::writeMesh(file, made.mesh, made.write);
  line.progress().throwIfCancelled();
  outputs.commit();
  std::cerr << "wrote " << outputs.names() << ": " << made.mesh.triangles.size() << " triangles\n";
  return kDone;
}

}  // namespace cli
