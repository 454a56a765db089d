// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/merge.h"

#include "base/lattice_transform.h"
#include "farm/tile_count.h"
#include "farm/tile_islands.h"
#include "farm/tile_merge.h"
#include "farm/tile_task.h"
#include "field/block_evaluator.h"
#include "field/block_layers.h"
#include "job/output_grids.h"
#include "job/point_attributes.h"
#include "surface/band_distances.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/file_hash.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_files.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_file.h"
#include "vdbtools/scene/prepared_scene.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

bool writes(const Manifest& manifest, std::uint64_t index, const std::string& name) {
  const std::vector<std::string>& names = manifest.tasks.at(index - 1).writes;
  return std::find(names.begin(), names.end(), name) != names.end();
}

void requireTiles(const Manifest& manifest) {
  if (manifest.kind != PlanKind::Tiles)
    throw std::invalid_argument(
        "the plan is not one of tiles: each of its tasks makes files of its own, and nothing is to be merged");
}

/// The job of a plan of tiles.
/// @param counts  whether the plan is to keep counts alone
/// @throw std::invalid_argument  the plan is of another kind, or its tasks keep something else
TileJob jobOf(const Manifest& manifest, bool counts) {
  requireTiles(manifest);
  if (counts && !makes(manifest, kMakeCount))
    throw std::invalid_argument(
        "the tasks of the plan keep their triangles, so merge them with --mesh or -o; only a plan "
        "with --make count is counted");
  if (!counts && makes(manifest, kMakeCount))
    throw std::invalid_argument(
        "the tasks of the plan keep counts alone; add them up with --counts F.json, or plan again with --make ply");
  return tileJob(manifest);
}

/// @throw DataError  no tile has a triangle
void requireTriangles(const MergeResult& result) {
  if (result.mesh.triangles > 0) return;
  if (result.crumbs) requireMoreThanCrumbs(*result.crumbs);
  throw DataError("the fractal is empty: no tile has a triangle; plan again with less detail or smaller voxels");
}

CrumbReport crumbsOf(const TaskRecord& record) {
  const auto count = [&](const char* name) {
    const auto found = record.counts.find(name);
    return found == record.counts.end() ? std::uint64_t{0} : found->second;
  };
  return {count(kCrumbsCount), count(kCrumbNodesCount)};
}

/// @return the crumbs that the tasks dropped, if they were to
/// @throw DataError  names the tasks that are not done
std::optional<CrumbReport> requireDone(const fs::path& folder, const TileJob& job, Monitor& monitor) {
  const Manifest& manifest = job.manifest;
  monitor.begin(PhaseKind::Checking, manifest.tasks.size());
  std::vector<std::uint64_t> missing;
  std::string reason;  // the first one's reason
  CrumbReport crumbs;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    if (const std::optional<TaskRecord> record = finishedTask(folder, manifest, index, FileCheck::Content)) {
      const CrumbReport more = crumbsOf(*record);
      crumbs = {sumOfCounts(crumbs.crumbs, more.crumbs), sumOfCounts(crumbs.nodes, more.nodes)};
    } else {
      if (missing.empty()) reason = taskStatus(folder, manifest, index, FileCheck::Content).error;
      missing.push_back(index);
    }
    monitor.advance(1);
    monitor.throwIfCancelled();
  }
  if (!missing.empty())
    throw DataError((missing.size() == 1 ? "task " : "tasks ") + taskList(missing) + " of " +
                    std::to_string(manifest.tasks.size()) + (missing.size() == 1 ? " is" : " are") +
                    " not done, or not as the plan has them" + (reason.empty() ? "" : " (" + reason + ")") +
                    "; run them and merge again");
  if (!dropsCrumbs(job.options)) return std::nullopt;
  return crumbs;
}

/// The attributes of a plan's points and voxels. No tile has them: they are computed when the tiles are merged.
class PlanAttributes {
 public:
  PlanAttributes(const FractalOptions& options, const fs::path& prepared)
      : mScene(opened(options, prepared)), mAttributes(mScene) {}

  const PointAttributes& operator*() const { return mAttributes; }
  const PointAttributes* operator->() const { return &mAttributes; }

 private:
  /// Opens the scene, with what is transferred from its target.
  static Scene opened(const FractalOptions& options, const fs::path& prepared) {
    Scene scene = readPreparedScene(options, prepared);
    if (options.output.attributes.transferred.empty()) return scene;
    const TargetOptions& target = options.target.value();
    verifiedHashes({&target.input, 1});
    scene.target->mesh = transferredMesh(options, *openTarget(target));
    return scene;
  }

  Scene mScene;
  PointAttributes mAttributes;
};

/// Null if none are requested.
std::unique_ptr<const PlanAttributes> planAttributes(const fs::path& folder, const TileJob& job) {
  if (job.options.output.attributes.empty()) return nullptr;
  return std::make_unique<const PlanAttributes>(job.options, folder / kPreparedName);
}

MeshWriteOptions meshOptions(const TileJob& job, MeshFormat format) {
  const TileLattice& lattice = job.lattice();
  MeshWriteOptions options = meshWriteOptions(format, job.options.output, job.manifest.metadata);
  options.voxelSize = lattice.voxelSize;
  options.box = meshBox({.domain = lattice.domain, .voxelSize = lattice.voxelSize});
  return options;
}

/// Meshes that are started on demand: one file, or several numbered ones.
class MeshFiles {
 public:
  /// @param attributes  of the points; may be null
  MeshFiles(const fs::path& path, const MeshWriteOptions& options, const PlanAttributes* attributes, bool numbered,
            OutputFiles& files, const Monitor& monitor)
      : mPath(path),
        mOptions(options),
        mAttributes(attributes),
        mNumbered(numbered),
        mFiles(files),
        mMonitor(monitor) {}

  MeshSink& next() {
    if (!mMeshes.empty()) mMeshes.back().finish();
    fs::path path = mPath;
    if (mNumbered)
      path.replace_filename(mPath.stem().string() + '.' + std::to_string(mMeshes.size() + 1) +
                            mPath.extension().string());
    MeshFile& mesh = mMeshes.emplace_back(mFiles.add(path), mOptions);
    if (!mAttributes) return mesh;
    return mAttributed.emplace_back(**mAttributes, mesh, mMonitor);
  }
  void finish() {
    if (!mMeshes.empty()) mMeshes.back().finish();
  }

 private:
  fs::path mPath;
  MeshWriteOptions mOptions;
  const PlanAttributes* mAttributes;
  bool mNumbered;
  OutputFiles& mFiles;
  const Monitor& mMonitor;
  std::list<MeshFile> mMeshes;
  std::list<AttributedSink> mAttributed;  ///< in front of the meshes
};

/// The islands of a plan that drops some of them.
struct PlanIslands {
  IslandOptions options;
  std::vector<TileIslandsReader> tiles;
  JoinedIslands joined;
  bool capMesh = false;  ///< whether the written mesh has caps

  std::uint64_t meshPoints() const { return joined.points + (capMesh ? joined.capPoints : 0); }
};

std::optional<PlanIslands> joinIslands(const fs::path& folder, const TileJob& job, Monitor& monitor) {
  if (!job.files.islands) return std::nullopt;
  const SurfaceOptions& options = job.options.surface;
  PlanIslands islands{.options = options.islands, .capMesh = options.cap || !job.lattice().bounded};
  for (std::uint64_t index = 1; index <= job.manifest.tasks.size(); ++index)
    islands.tiles.emplace_back(folder / tileIslandsName(index));
  islands.joined = joinIslands(islands.tiles, islands.options, job.lattice().voxelSize, monitor);
  return islands;
}

TileReader openTile(const fs::path& folder, std::uint64_t index, const PlanIslands* islands, bool caps) {
  TileReader tile(folder / tileMeshName(index));
  if (islands) tile.setFilter({islands->joined.kept[index - 1], caps});
  return tile;
}

std::vector<TileReader> openTiles(const fs::path& folder, const TileJob& job, const PlanIslands* islands, bool caps) {
  const std::uint64_t count = job.manifest.tasks.size();
  std::vector<TileReader> tiles;
  tiles.reserve(count);
  for (std::uint64_t index = 1; index <= count; ++index) tiles.push_back(openTile(folder, index, islands, caps));
  return tiles;
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

/// Adds the leaves and the active values of one tree to another.
void addPart(FloatTree& whole, const FloatTree& part) {
  for (auto leaf = part.cbeginLeaf(); leaf; ++leaf) {
    Leaf* const there = whole.probeLeaf(leaf->origin());
    if (!there) {
      whole.addLeaf(new Leaf(*leaf));
      continue;
    }
    for (auto value = leaf->cbeginValueOn(); value; ++value) there->setValueOn(value.pos(), *value);
  }
}

/// The mesh of the islands that are kept, closed by caps.
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

/// The distances to the remaining mesh; negative at the nodes of the islands that are kept.
FloatGrid::Ptr keptSurface(const fs::path& folder, const TileJob& job, const PlanIslands& islands, Monitor& monitor) {
  const Mesh mesh = keptMesh(folder, job, islands, monitor);
  if (mesh.triangles.empty()) return nullptr;
  const TileLattice& lattice = job.lattice();
  FloatGrid::Ptr surface = bandDistances(mesh, lattice.voxelSize, lattice.domain, monitor);
  openvdb::tree::ValueAccessor<FloatTree> leaves(surface->tree());
  monitor.begin(PhaseKind::Signs, islands.tiles.size());
  for (std::size_t tile = 0; tile < islands.tiles.size(); ++tile) {
    islands.tiles[tile].forEachOwn([&](std::span<const InsideRun> runs) {
      for (const InsideRun& run : runs) {
        if (!islands.joined.kept[tile][run.part]) continue;
        for (int z = run.first; z <= run.last; z = (z | (kBlock - 1)) + 1) {
          Leaf* const leaf = leaves.probeLeaf({run.x, run.y, z});
          if (!leaf) continue;
          const int end = std::min(run.last, z | (kBlock - 1));
          for (int k = z; k <= end; ++k)
            if (const openvdb::Index at = Leaf::coordToOffset({run.x, run.y, k}); leaf->isValueOn(at))
              leaf->setValueOnly(at, -leaf->getValue(at));
        }
      }
    });
    monitor.advance(1);
    monitor.throwIfCancelled();
  }
  return surface;
}

/// The grids of a plan while their parts arrive.
struct GridParts {
  FloatGrid::Ptr surface;
  FractalField field;
};

FloatGrid::Ptr partNamed(const VdbFile& file, const char* name) {
  for (const auto& grid : file.grids)
    if (grid->getName() == name) return openvdb::gridPtrCast<FloatGrid>(grid);
  return nullptr;
}

GridParts readGrids(const fs::path& folder, const TileJob& job, Monitor& monitor) {
  const Manifest& manifest = job.manifest;
  const TileLattice& lattice = job.lattice();
  GridParts parts{.field = emptyField({.domain = lattice.domain,
                                       .bounded = lattice.bounded,
                                       .voxelSize = lattice.voxelSize,
                                       .window = lattice.domain,
                                       .blocks = nullptr},
                                      true)};
  monitor.begin(PhaseKind::MergingGrids, manifest.tasks.size());
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    if (!writes(manifest, index, tileGridsName(index))) continue;
    const VdbFile file = readVdb(folder / tileGridsName(index));
    if (const FloatGrid::Ptr part = partNamed(file, "surface"); part && !part->empty()) {
      if (!parts.surface) {
        parts.surface = FloatGrid::create(part->background());
        parts.surface->setTransform(latticeTransform(lattice.voxelSize));
      }
      addPart(parts.surface->tree(), part->tree());
    }
    if (const FloatGrid::Ptr part = partNamed(file, "logmodulus")) addPart(parts.field.field->tree(), part->tree());
    if (const FloatGrid::Ptr part = partNamed(file, "iterations"))
      addPart(parts.field.iterations->tree(), part->tree());
    monitor.advance(1);
    monitor.throwIfCancelled();
  }
  return parts;
}

std::vector<openvdb::GridBase::Ptr> mergeGrids(const fs::path& folder, const TileJob& job, const PlanIslands* islands,
                                               const PlanAttributes* attributes, MergeResult& result,
                                               Monitor& monitor) {
  GridParts parts = readGrids(folder, job, monitor);
  if (job.grids.needsLevelSet()) {
    if (islands) parts.surface = keptSurface(folder, job, *islands, monitor);
    if (!parts.surface && result.crumbs) requireMoreThanCrumbs(*result.crumbs);
    if (!parts.surface) throw DataError("the fractal is empty: no tile has a part of its level set");
    finishLevelSet(*parts.surface);
    result.check = checkSurface(*parts.surface);
    if (!result.check.failure.empty())
      throw std::logic_error("the level set fails OpenVDB's check: " + result.check.failure);
    result.bandVoxels = parts.surface->activeVoxelCount();
  }
  if (job.grids.has(OutputGrid::LogModulus)) {
    fillTiles(parts.field);
    if (islands) dropIslands(parts.field, islands->options, monitor);
  }
  std::optional<Scene> scene;
  std::optional<FieldSource> source;
  if (job.grids.has(OutputGrid::Versor))
    source.emplace(scene.emplace(readPreparedScene(job.options, folder / kPreparedName)).source());
  return outputGrids(job.grids,
                     {.surface = parts.surface,
                      .field = &parts.field,
                      .source = source ? &*source : nullptr,
                      .attributes = attributes ? &**attributes : nullptr},
                     monitor);
}

void commit(OutputFiles& files, MergeResult& result) {
  for (const AtomicFile& file : files.files()) result.files.push_back(file.target());
  files.commit();
}

/// The names of pieces of a plan that remain separate files.
fs::path pieceOf(const fs::path& listed, std::uint64_t index, const char* extension) {
  return fs::path((listed.parent_path() / listed.stem()).string() + '.' + taskName(index) + extension);
}

/// Writes one tile's own files, and returns its entry in the index.
nlohmann::json writeOneTile(const fs::path& folder, const TileJob& job, std::uint64_t index, const fs::path& listed,
                            const InputFiles& inputs, const PlanIslands* islands, const PlanAttributes* attributes,
                            MergeResult& result, Monitor& monitor) {
  using nlohmann::json;
  const Manifest& manifest = job.manifest;
  const TileLattice& lattice = job.lattice();
  const openvdb::CoordBBox box = manifest.tasks[index - 1].box.value();
  const openvdb::Vec3d low = box.min().asVec3d() * lattice.voxelSize, high = box.max().asVec3d() * lattice.voxelSize;
  json entry = {{"tile", index},
                {"nodes", {box.min()[0], box.min()[1], box.min()[2], box.max()[0], box.max()[1], box.max()[2]}},
                {"box", {low[0], low[1], low[2], high[0], high[1], high[2]}},
                {"files", json::array()}};
  OutputFiles files(inputs);
  if (makesMesh(manifest)) {
    std::vector<TileReader> tile;
    tile.push_back(openTile(folder, index, islands, islands && islands->capMesh));
    const std::uint64_t points = sumOfCounts(tile[0].counts().points, tile[0].counts().guests);
    if (points > kMostMeshPoints)
      throw DataError("tile " + std::to_string(index) + " has " + std::to_string(points) +
                      " points, and its PLY is to have up to " + std::to_string(kMostMeshPoints) +
                      "; plan again with more tiles");
    MeshCounts counts;
    {
      MeshFiles meshes(pieceOf(listed, index, ".ply"), meshOptions(job, MeshFormat::Ply), attributes, false, files,
                       monitor);
      const std::function<MeshSink&()> next = [&]() -> MeshSink& { return meshes.next(); };
      counts = mergeTiles(tile, {.keepGuests = true}, next, monitor);
      meshes.finish();
    }
    if (counts.triangles == 0) {
      files.clear();
      counts = {};
    }
    entry["points"] = counts.points;
    entry["triangles"] = counts.triangles;
    result.mesh.points += counts.points;
    result.mesh.triangles += counts.triangles;
  }
  if (makes(manifest, "vdb")) {
    const VdbFile file = readVdb(folder / tileGridsName(index));
    if (const FloatGrid::Ptr part = partNamed(file, "surface"); part && !part->empty()) {
      finishLevelSet(*part);
      entry["band_voxels"] = part->activeVoxelCount();
      result.bandVoxels += part->activeVoxelCount();
      std::vector<openvdb::GridBase::Ptr> grids = {part};
      if (attributes)
        for (const openvdb::GridBase::Ptr& grid : attributeGrids(**attributes, *part, monitor)) grids.push_back(grid);
      VdbWriteOptions options = vdbWriteOptions(job.options.output, manifest.metadata);
      options.half = false;
      files.add(pieceOf(listed, index, ".vdb")).stream() << encodeVdb(grids, options);
    }
  }
  const std::size_t before = result.files.size();
  commit(files, result);
  for (std::size_t i = before; i < result.files.size(); ++i)
    entry["files"].push_back({{"name", result.files[i].filename().string()},
                              {"bytes", fs::file_size(result.files[i])},
                              {"sha256", sha256OfFile(result.files[i])}});
  return entry;
}

/// "; plan again with --make vdb,ply,obj"
std::string planAgainWith(const Manifest& manifest, const std::string& format) {
  std::string list;
  for (const std::string& made : manifest.makes) list += made + ',';
  return "; plan again with --make " + list + format;
}

/// @throw CreateError  no file can be created there
void requirePlace(const fs::path& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  // A pipe must be opened only once: its reader takes the end of the first writer for the end of the file.
  if (type == fs::file_type::fifo || type == fs::file_type::socket) return;
  const AtomicFile claim(path);
}

void requireMergeable(const fs::path& folder, const TileJob& job, const MergeOptions& options) {
  const Manifest& manifest = job.manifest;
  if (!options.vdb && !options.mesh) throw std::invalid_argument("no file was named for what is merged");
  if (options.vdb && !makes(manifest, "vdb"))
    throw std::invalid_argument("the tasks of the plan make no grids, so '" + inOneLine(options.vdb->native()) +
                                "' cannot be merged from them" + planAgainWith(manifest, "vdb"));
  if (options.mesh) {
    const std::string name = "'" + inOneLine(options.mesh->native()) + "'",
                      format = lowerExtension(*options.mesh).substr(1);
    if (!makesMesh(manifest))
      throw std::invalid_argument("the tasks of the plan make no mesh, so " + name + " cannot be merged from them" +
                                  planAgainWith(manifest, format));
    // Comes first, so that the message is about a format that cannot hold the mesh.
    const bool needsDoubles = needsDoublePositions(meshOptions(job, meshFormat(*options.mesh)));
    if (needsDoubles && !tilesNeedDoubles(job))
      throw std::invalid_argument("the tasks of the plan keep fewer digits than " + name + " needs" +
                                  planAgainWith(manifest, format));
  }
  OutputPlaces places(planInputs(folder, manifest));
  for (const std::optional<fs::path>& file : {options.vdb, options.mesh})
    if (file) {
      places.claim(*file);
      requirePlace(*file);
    }
}

void requireMergeable(const fs::path& folder, const TileJob& job, const fs::path& index) {
  const Manifest& manifest = job.manifest;
  if (makes(manifest, "vdb") && job.files.islands)
    throw std::invalid_argument(
        "islands are dropped, and the distances to what is left of them are not known tile by tile; merge into one "
        "VDB, or plan again with --make ply alone");
  OutputPlaces places(planInputs(folder, manifest));
  places.claim(index);
  for (std::uint64_t task = 1; task <= manifest.tasks.size(); ++task)
    for (const char* extension : {".ply", ".vdb"}) places.claim(pieceOf(index, task, extension));
  requirePlace(index);
}

void requireCountsPlace(const fs::path& folder, const Manifest& manifest, const fs::path& file) {
  OutputPlaces places(planInputs(folder, manifest));
  places.claim(file);
  requirePlace(file);
}

}  // namespace

void requireMergeable(const fs::path& folder, const Manifest& manifest, const MergeOptions& options) {
  requireMergeable(folder, jobOf(manifest, false), options);
}

void requireMergeable(const fs::path& folder, const Manifest& manifest, const fs::path& index) {
  requireMergeable(folder, jobOf(manifest, false), index);
}

void requireCounts(const fs::path& folder, const Manifest& manifest, const fs::path& file) {
  jobOf(manifest, true);
  requireCountsPlace(folder, manifest, file);
}

MergeResult mergePlan(const fs::path& folder, const Manifest& manifest, const MergeOptions& options, Monitor& monitor) {
  const TileJob job = jobOf(manifest, false);
  requireMergeable(folder, job, options);
  OutputFiles files(planInputs(folder, manifest));
  sweepPlan(folder, manifest);
  AtomicFile* const vdb = options.vdb ? &files.add(*options.vdb) : nullptr;
  MergeResult result{.crumbs = requireDone(folder, job, monitor)};
  const std::optional<PlanIslands> joined = joinIslands(folder, job, monitor);
  const PlanIslands* const islands = joined ? &*joined : nullptr;
  if (islands) result.islands = islands->joined.report;
  const std::unique_ptr<const PlanAttributes> attributes = planAttributes(folder, job);
  if (options.mesh) {
    result.mesh = mergeMesh(folder, job, options, islands, attributes.get(), files, monitor);
    requireTriangles(result);
  }
  if (vdb) {
    const std::vector<openvdb::GridBase::Ptr> grids =
        mergeGrids(folder, job, islands, attributes.get(), result, monitor);
    monitor.begin(PhaseKind::Writing, 0);
    vdb->stream() << encodeVdb(grids, vdbWriteOptions(job.options.output, manifest.metadata));
  }
  monitor.throwIfCancelled();
  commit(files, result);
  return result;
}

MergeResult mergeCounts(const fs::path& folder, const Manifest& manifest, const fs::path& file, Monitor& monitor) {
  const TileJob job = jobOf(manifest, true);
  requireCountsPlace(folder, manifest, file);
  OutputFiles files(planInputs(folder, manifest));
  AtomicFile& output = files.add(file);
  sweepPlan(folder, manifest);
  MergeResult result{.crumbs = requireDone(folder, job, monitor)};
  monitor.begin(PhaseKind::Merging, manifest.tasks.size());
  std::vector<TileCount> tiles;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    const fs::path path = folder / tileCountName(index);
    try {
      tiles.push_back(parseTileCount(readWholeFile(path)));
    } catch (const DataError& error) {
      throw DataError("'" + inOneLine(path.native()) + "' is no count of a tile: " + error.what() +
                      "; run its task again");
    }
    monitor.advance(1);
    monitor.throwIfCancelled();
  }
  const TileCount whole = addedUp(tiles);
  result.mesh = {.points = whole.points, .triangles = whole.triangles};
  requireTriangles(result);
  nlohmann::ordered_json root = {{"juliavdb", "count"},
                                 {"version", manifest.version},
                                 {"voxel_size", job.lattice().voxelSize},
                                 {"tiles", manifest.tasks.size()}};
  root.update(jsonOf(whole));
  root["recipe"] = manifest.metadata;
  output.stream() << root.dump(1) << '\n';
  commit(files, result);
  return result;
}

MergeResult writeTileFiles(const fs::path& folder, const Manifest& manifest, const fs::path& index, Monitor& monitor) {
  const TileJob job = jobOf(manifest, false);
  requireMergeable(folder, job, index);
  const InputFiles inputs = planInputs(folder, manifest);
  OutputFiles files(inputs);
  AtomicFile& file = files.add(index);
  sweepPlan(folder, manifest);
  MergeResult result{.crumbs = requireDone(folder, job, monitor)};
  const std::optional<PlanIslands> islands = joinIslands(folder, job, monitor);
  if (islands) result.islands = islands->joined.report;
  const std::unique_ptr<const PlanAttributes> attributes = planAttributes(folder, job);
  const TileLattice& lattice = job.lattice();
  nlohmann::ordered_json root = {{"juliavdb", "tiles"},
                                 {"version", manifest.version},
                                 {"voxel_size", lattice.voxelSize},
                                 {"recipe", manifest.metadata}};
  nlohmann::json tiles = nlohmann::json::array();
  for (std::uint64_t i = 1; i <= manifest.tasks.size(); ++i) {
    tiles.push_back(
        writeOneTile(folder, job, i, index, inputs, islands ? &*islands : nullptr, attributes.get(), result, monitor));
    monitor.throwIfCancelled();
  }
  if (result.files.empty() && result.crumbs) requireMoreThanCrumbs(*result.crumbs);
  if (result.files.empty()) throw DataError("the fractal is empty: no tile has a surface");
  root["points"] = result.mesh.points;
  root["triangles"] = result.mesh.triangles;
  root["tiles"] = tiles;
  file.stream() << root.dump(1) << '\n';
  commit(files, result);
  return result;
}

}  // namespace vdbtools::farm
