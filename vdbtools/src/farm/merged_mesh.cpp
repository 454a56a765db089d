// SPDX-License-Identifier: Apache-2.0
#include "farm/merged_mesh.h"

#include "scene/prepared_scene.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/job/fractal_job.h"

#include <functional>
#include <list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;

/// Reads the scene, with the mesh of its target if attributes follow from it.
Scene sceneWithMesh(const FractalOptions& options, const fs::path& prepared) {
  Scene scene = readPreparedScene(options, prepared);
  const bool needsVelocity = options.velocity && !scene.velocity;
  if (options.output.attributes.transferred.empty() && !needsVelocity) return scene;
  std::vector<NamedFile> files = {options.target->input};
  if (needsVelocity)
    for (const std::optional<NamedFile>& file : {options.velocity->before, options.velocity->after})
      if (file) files.push_back(*file);
  verifiedHashes(files);
  Monitor unwatched;
  const std::unique_ptr<const TargetInput> input = openTarget(options.target.value(), unwatched);
  scene.target->mesh = transferredMesh(options, *input);
  if (needsVelocity) scene.velocity = velocityOf(options, input->mesh());
  return scene;
}

std::vector<TileReader> openTiles(const fs::path& folder, const TileJob& job, const PlanIslands* islands, bool caps) {
  const std::uint64_t count = job.manifest.tasks.size();
  std::vector<TileReader> tiles;
  tiles.reserve(count);
  for (std::uint64_t index = 1; index <= count; ++index) tiles.push_back(openTile(folder, index, islands, caps));
  return tiles;
}

/// Mesh files that are started on demand: one, or several numbered ones.
class MeshFiles {
 public:
  MeshFiles(const PlanMesh& mesh, OutputFiles& files, const Monitor& monitor)
      : mMesh(mesh), mFiles(files), mMonitor(monitor) {}

  /// The next file, after the one before is finished.
  MeshSink& next() {
    finish();
    std::filesystem::path path = mMesh.path;
    if (mMesh.numbered)
      path.replace_filename(path.stem().string() + '.' + std::to_string(mMeshes.size() + 1) +
                            path.extension().string());
    MeshSink* sink = &mMeshes.emplace_back(mFiles.add(path), mMesh.options);
    if (mMesh.offset != openvdb::Vec3d(0)) sink = &mMoved.emplace_back(mMesh.offset, *sink);
    if (mMesh.attributes) sink = &mAttributed.emplace_back(**mMesh.attributes, *sink, mMonitor);
    return *sink;
  }
  void finish() {
    if (!mMeshes.empty()) mMeshes.back().finish();
  }

 private:
  const PlanMesh& mMesh;
  OutputFiles& mFiles;
  const Monitor& mMonitor;
  std::list<MeshFile> mMeshes;
  std::list<MovedMeshSink> mMoved;        ///< in front of the meshes
  std::list<AttributedSink> mAttributed;  ///< in front of these
};

}  // namespace

PlanAttributes::PlanAttributes(const FractalOptions& options, const fs::path& prepared)
    : mScene(sceneWithMesh(options, prepared)), mAttributes(mScene) {}

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

MeshWriteOptions meshOptions(const TileJob& job, const FileFormat& format) {
  const TileLattice& lattice = job.lattice();
  MeshWriteOptions options = meshWriteOptions(format, job.options.output, job.manifest.metadata);
  options.voxelSize = lattice.voxelSize;
  options.box = meshBox({.domain = lattice.domain, .voxelSize = lattice.voxelSize});
  return options;
}

TileReader openTile(const fs::path& folder, std::uint64_t index, const PlanIslands* islands, bool caps) {
  TileReader tile(folder / tileMeshName(index));
  if (islands) tile.setFilter({islands->joined.keptParts[index - 1], caps});
  return tile;
}

MeshCounts writeMesh(std::vector<TileReader>& tiles, const TileMergeOptions& merging, const PlanMesh& mesh,
                     OutputFiles& files, Monitor& monitor) {
  MeshFiles meshes(mesh, files, monitor);
  const std::function<MeshSink&()> next = [&]() -> MeshSink& { return meshes.next(); };
  const MeshCounts counts = mergeTiles(tiles, merging, next, monitor);
  meshes.finish();
  return counts;
}

MeshCounts mergeMesh(const fs::path& folder, const TileJob& job, const MergeOptions& options,
                     const PlanIslands* islands, const PlanAttributes* attributes, OutputFiles& files,
                     Monitor& monitor) {
  const FileFormat& format = meshFormat(*options.mesh);
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
  return writeMesh(tiles, {.mostPoints = options.mostPoints},
                   {.path = *options.mesh,
                    .options = written,
                    .attributes = attributes,
                    .offset = latticeOffset(job.options, job.lattice().voxelSize),
                    .numbered = cut},
                   files, monitor);
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
