// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "grid_file.h"
#include "interruption.h"
#include "merge_request.h"
#include "options.h"
#include "output.h"
#include "report.h"

#include "vdbtools/farm/merge.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/fractal_options.h"

#include <stdexcept>

namespace cli {
namespace {

constexpr Usage kMergeUsage = {
    "merge", "DIR [-o F.vdb] [--mesh F.ply] [--index F.json] [--counts F.json]",
    "Puts the tiles of a plan together, once all tasks are done: the same bytes as 'juliavdb fractal' would have "
    "written. The mesh is written while the tiles are read, so it may be far larger than the memory; a VDB is held in "
    "memory whole. A fractal that is too large for one file can stay in pieces: --index writes each tile as a mesh and "
    "a VDB of its own, F.0001.ply and F.0001.vdb and so on, and a JSON file that lists them. Of a plan with "
    "--make count, --counts writes how many points and triangles all tiles have.",
    "  juliavdb merge farm -o bunny.vdb --mesh bunny.ply\n"
    "  juliavdb merge farm --index pieces.json\n"};

}  // namespace

int runMerge(const Arguments& arguments) {
  CommandLine line(kMergeUsage, {});
  line.addPositional("folder", 1, "the folder of the plan");
  addMergeOptions(line);
  if (!line.parse(arguments)) return kDone;
  if (!line.has("folder")) throw std::invalid_argument("no plan was given; name its folder");
  const std::filesystem::path folder = line.text("folder");
  const MergeRequest request = parseMergeRequest(line);
  if (request.empty())
    throw std::invalid_argument(
        "no output was given; use -o F.vdb, --mesh F.ply, both, --index F.json, or --counts F.json");
  const vdbtools::farm::MergeOptions& options = request.files;
  const vdbtools::farm::Manifest manifest = vdbtools::farm::readManifest(folder);
  const vdbtools::farm::MergeResult result =
      request.counts  ? vdbtools::farm::mergeCounts(folder, manifest, *request.counts, line.progress())
      : request.index ? vdbtools::farm::writeTileFiles(folder, manifest, *request.index, line.progress())
                      : vdbtools::farm::mergePlan(folder, manifest, options, line.progress());

  for (const std::filesystem::path& file : result.files) report().wrote(file);
  workIsDone();
  report().count("triangles", result.mesh.triangles);
  report().count("bandVoxels", result.bandVoxels);
  constexpr std::size_t kNamed = 4;
  report().text() << "wrote ";
  for (std::size_t i = 0; i < std::min(kNamed, result.files.size()); ++i)
    report().text() << (i == 0 ? "" : ", ") << result.files[i].string();
  if (result.files.size() > kNamed) report().text() << " and " << result.files.size() - kNamed << " more";
  report().text() << " from " << manifest.tasks.size() << (manifest.tasks.size() == 1 ? " tile" : " tiles");
  if (result.mesh.triangles > 0) report().text() << ", " << result.mesh.triangles << " triangles";
  if (result.bandVoxels > 0) report().text() << ", " << result.bandVoxels << " voxels in the band";
  if (result.crumbs) tellCrumbs(*result.crumbs, manifest.lattice.value().voxelSize, std::nullopt);
  if (result.islands)
    report().text() << ", " << result.islands->keptIslands << " of " << result.islands->islands << " islands kept";
  report().text() << '\n';
  tellClamped(result.clamped);
  const std::vector<vdbtools::VertexColumn> columns =
      vdbtools::meshColumns(vdbtools::parseFractalOptions(manifest.recipe).output.attributes);
  for (const std::optional<std::filesystem::path>& file : {options.grids, options.mesh})
    if (file) noteLeftOut(*file, columns);
  const std::size_t meshes = result.files.size() - (options.grids ? 1 : 0);
  if (options.mesh && meshes > 1)
    report().text() << "note: the mesh has more than " << options.mostPoints << " points and is in " << meshes
                    << " files; neighbours share the points of the layer where it was cut\n";
  return kDone;
}

}  // namespace cli
