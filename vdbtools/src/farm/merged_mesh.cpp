// SPDX-License-Identifier: Apache-2.0
#include "farm/merged_mesh.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/job/fractal_files.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/scene/prepared_scene.h"

#include <functional>
#include <string>
#include <utility>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;

/// Reads the scene, with the mesh of its target if attributes are transferred from it.
Scene sceneWithTransfers(const FractalOptions& options, const fs::path& prepared) {
  Scene scene = readPreparedScene(options, prepared);
  if (options.output.attributes.transferred.empty()) return scene;
  const TargetOptions& target = options.target.value();
  verifiedHashes({&target.input, 1});
  scene.target->mesh = transferredMesh(options, *openTarget(target));
  return scene;
}

std::vector<TileReader> openTiles(const fs::path& folder, const TileJob& job, const PlanIslands* islands, bool caps) {
  const std::uint64_t count = job.manifest.tasks.size();
  std::vector<TileReader> tiles;
  tiles.reserve(count);
  for (std::uint64_t index = 1; index <= count; ++index) tiles.push_back(openTile(folder, index, islands, caps));
  return tiles;
}

}  // namespace

PlanAttributes::PlanAttributes(const FractalOptions& options, const fs::path& prepared)
    : mScene(sceneWithTransfers(options, prepared)), mAttributes(mScene) {}

std::unique_ptr<const PlanAttributes> planAttributes(const fs::path& folder, const TileJob& job) {
  if (job.options.output.attributes.empty()) return nullptr;
  return std::make_unique<const PlanAttributes>(job.options, folder / kPreparedName);
}

std::optional<PlanIslands> joinIslands(const fs::path& folder, const TileJob& job, Monitor& monitor) {
  if (!job.files.islands) return std::nullopt;
  const SurfaceOptions& options = job.options.surface;
  PlanIslands islands{.options = options.islands, .capMesh = options.cap || !job.lattice().bounded};
  for (std::uint64_t index = 1; index <= job.manifest.tasks.size(); ++index)
    islands.tiles.emplace_back(folder / tileIslandsName(index));
  islands.joined = joinIslands(islands.tiles, islands.options, job.lattice().voxelSize, monitor);
  return islands;
}

MeshWriteOptions meshOptions(const TileJob& job, MeshFormat format) {
  const TileLattice& lattice = job.lattice();
  MeshWriteOptions options = meshWriteOptions(format, job.options.output, job.manifest.metadata);
  options.voxelSize = lattice.voxelSize;
  options.box = meshBox({.domain = lattice.domain, .voxelSize = lattice.voxelSize});
  return options;
}

MeshSink& MeshFiles::next() {
  if (!mMeshes.empty()) mMeshes.back().finish();
  fs::path path = mPath;
  if (mNumbered)
    path.replace_filename(mPath.stem().string() + '.' + std::to_string(mMeshes.size() + 1) +
                          mPath.extension().string());
  MeshFile& mesh = mMeshes.emplace_back(mFiles.add(path), mOptions);
  if (!mAttributes) return mesh;
  return mAttributed.emplace_back(**mAttributes, mesh, mMonitor);
}
TileReader openTile(const fs::path& folder, std::uint64_t index, const PlanIslands* islands, bool caps) {
  TileReader tile(folder / tileMeshName(index));
  if (islands) tile.setFilter({islands->joined.kept[index - 1], caps});
  return tile;
}

MeshCounts mergeMesh(const fs::path& folder, const TileJob& job, const MergeOptions& options,
                     const PlanIslands* islands, const PlanAttributes* attributes, OutputFiles& files,
                     Monitor& monitor) {
  const MeshFormat format = meshFormat(*options.mesh);
  std::vector<TileReader> tiles = openTiles(folder, job, islands, islands && islands->capMesh);
  std::uint64_t points = 0, triangles = 0;
  for (const TileReader& tile : tiles) {
    points = sumOfCounts(points, tile.counts().points);
    triangles = sumOfCounts(triangles, tile.counts().triangles);
  }
  if (islands) {
    points = islands->meshPoints();
    triangles = 0;  // how many are left is not known yet
  }
  const bool cut = points > options.mostPoints;
  const MeshWriteOptions written = meshOptions(job, format);
  if (!cut) requireMeshCounts(written, true, points, triangles);
  MeshFiles meshes(*options.mesh, written, attributes, cut, files, monitor);
  const std::function<MeshSink&()> next = [&]() -> MeshSink& { return meshes.next(); };
  const MeshCounts counts = mergeTiles(tiles, {.mostPoints = options.mostPoints}, next, monitor);
  meshes.finish();
  return counts;
}

Mesh keptMesh(const fs::path& folder, const TileJob& job, const PlanIslands& islands, Monitor& monitor) {
  std::vector<TileReader> tiles = openTiles(folder, job, &islands, true);
  Mesh mesh;
  MeshCollector collector(mesh);
  bool begun = false;
  const std::function<MeshSink&()> next = [&]() -> MeshSink& {
    if (std::exchange(begun, true))
      throw DataError("the mesh has more than " + std::to_string(kMostMeshPoints) +
                      " points, too many for the distances to what is left of the islands; merge the mesh alone");
    return collector;
  };
  mergeTiles(tiles, {.mostPoints = kMostMeshPoints}, next, monitor);
  return mesh;
}

}  // namespace vdbtools::farm
