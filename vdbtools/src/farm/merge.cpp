// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/merge.h"

#include "base/lattice_transform.h"
#include "farm/tile_islands.h"
#include "farm/tile_merge.h"
#include "farm/tile_task.h"
#include "field/block_evaluator.h"
#include "field/block_layers.h"
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
bool planDropsIslands(const Manifest& manifest) {
  return !manifest.tasks.empty() && writes(manifest, 1, tileIslandsName(1));
}

void requireTiles(const Manifest& manifest) {
  if (manifest.kind != PlanKind::Tiles)
    throw std::invalid_argument(
        "the plan is not one of tiles: each of its tasks makes files of its own, and nothing is to be merged");
}

CrumbReport crumbsOf(const TaskRecord& record) {
  const auto count = [&](const char* name) {
    const auto found = record.counts.find(name);
    // A side-car may say anything.
    constexpr double kMost = 9e15;
    return found != record.counts.end() && found->second >= 0 && found->second <= kMost
               ? static_cast<std::uint64_t>(found->second)
               : 0;
  };
  return {count(kCrumbsCount), count(kCrumbNodesCount)};
}

/// @return the crumbs that the tasks have dropped, if they were to
/// @throw DataError  naming the tasks that are not done
std::optional<CrumbReport> requireDone(const fs::path& folder, const Manifest& manifest, Monitor& monitor) {
  monitor.begin("checking", manifest.tasks.size());
  std::vector<std::uint64_t> missing;
  std::string reason;  // of the first
  CrumbReport crumbs;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    if (const std::optional<TaskRecord> record = finishedTask(folder, manifest, index, FileCheck::Content)) {
      crumbs += crumbsOf(*record);
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
  if (!dropsCrumbs(parseFractalOptions(manifest.recipe))) return std::nullopt;
  return crumbs;
}

/// The attributes of a plan's points and voxels, which no tile has: they are computed when the tiles are merged.
class PlanAttributes {
 public:
  PlanAttributes(const FractalOptions& options, const fs::path& prepared)
      : mScene(opened(options, prepared)), mAttributes(mScene) {}

  const PointAttributes& operator*() const { return mAttributes; }
  const PointAttributes* operator->() const { return &mAttributes; }

 private:
  /// The scene, with what is transferred from its target.
  static Scene opened(const FractalOptions& options, const fs::path& prepared) {
    Scene scene = readPreparedScene(options, prepared);
    if (options.output.attributes.transferred.empty()) return scene;
    const TargetOptions& target = options.target.value();
    verifiedHashes({&target.input, 1});
    scene.targetMesh = transferredMesh(options, *openTarget(target));
    return scene;
  }

  Scene mScene;
  PointAttributes mAttributes;
};

/// None if none are wanted.
std::unique_ptr<const PlanAttributes> planAttributes(const fs::path& folder, const Manifest& manifest) {
  const FractalOptions options = parseFractalOptions(manifest.recipe);
  if (options.output.attributes.empty()) return nullptr;
  return std::make_unique<const PlanAttributes>(options, folder / kPreparedName);
}

MeshWriteOptions meshOptions(const Manifest& manifest, MeshFormat format) {
  const TileLattice& lattice = manifest.lattice.value();
  MeshWriteOptions options = meshWriteOptions(format, parseFractalOptions(manifest.recipe).output, manifest.metadata);
  options.voxelSize = lattice.voxelSize;
  options.box = meshBox({.domain = lattice.domain, .voxelSize = lattice.voxelSize});
  return options;
}

/// Meshes that begin when they are asked for: one file, or several with numbers.
class MeshFiles {
 public:
  /// @param attributes  of the points; or null
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

/// The islands of a plan that drops some.
struct PlanIslands {
  IslandOptions options;
  std::vector<TileIslandsReader> tiles;
  JoinedIslands joined;
  bool capMesh = false;  ///< whether the mesh that is written has caps

  std::uint64_t meshPoints() const { return joined.points + (capMesh ? joined.capPoints : 0); }
};

std::optional<PlanIslands> joinIslands(const fs::path& folder, const Manifest& manifest, Monitor& monitor) {
  if (!planDropsIslands(manifest)) return std::nullopt;
  const SurfaceOptions options = parseFractalOptions(manifest.recipe).surface;
  PlanIslands islands{.options = options.islands, .capMesh = options.cap || !manifest.lattice.value().bounded};
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index)
    islands.tiles.emplace_back(folder / tileIslandsName(index));
  islands.joined = joinIslands(islands.tiles, islands.options, manifest.lattice->voxelSize, monitor);
  return islands;
}

TileReader openTile(const fs::path& folder, std::uint64_t index, const PlanIslands* islands, bool caps) {
  TileReader tile(folder / tileMeshName(index));
  if (islands) tile.setFilter({islands->joined.kept[index - 1], caps});
  return tile;
}

std::vector<TileReader> openTiles(const fs::path& folder, const Manifest& manifest, const PlanIslands* islands,
                                  bool caps) {
  std::vector<TileReader> tiles;
  tiles.reserve(manifest.tasks.size());
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index)
    tiles.push_back(openTile(folder, index, islands, caps));
  return tiles;
}

MeshCounts mergeMesh(const fs::path& folder, const Manifest& manifest, const MergeOptions& options,
                     const PlanIslands* islands, const PlanAttributes* attributes, OutputFiles& files,
                     Monitor& monitor) {
  const MeshFormat format = meshFormat(*options.mesh);
  std::vector<TileReader> tiles = openTiles(folder, manifest, islands, islands && islands->capMesh);
  std::uint64_t points = 0;
  for (const TileReader& tile : tiles) points += tile.counts().points;
  if (islands) points = islands->meshPoints();
  MeshFiles meshes(*options.mesh, meshOptions(manifest, format), attributes, points > options.mostPoints, files,
                   monitor);
  const std::function<MeshSink&()> next = [&]() -> MeshSink& { return meshes.next(); };
  const MeshCounts counts = mergeTiles(tiles, {.mostPoints = options.mostPoints}, next, monitor);
  meshes.finish();
  return counts;
}

/// Adds the active values of one tree to another one, and its leaves.
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

/// The mesh that is left of the islands, closed by caps.
Mesh keptMesh(const fs::path& folder, const Manifest& manifest, const PlanIslands& islands, Monitor& monitor) {
  std::vector<TileReader> tiles = openTiles(folder, manifest, &islands, true);
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

/// The distances to the mesh that is left; negative at the nodes of the islands that are kept.
FloatGrid::Ptr keptSurface(const fs::path& folder, const Manifest& manifest, const PlanIslands& islands,
                           Monitor& monitor) {
  const Mesh mesh = keptMesh(folder, manifest, islands, monitor);
  if (mesh.triangles.empty()) return nullptr;
  const TileLattice& lattice = manifest.lattice.value();
  FloatGrid::Ptr surface = bandDistances(mesh, lattice.voxelSize, lattice.domain, monitor);
  openvdb::tree::ValueAccessor<FloatTree> leaves(surface->tree());
  monitor.begin("signs", islands.tiles.size());
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

/// The grids of a plan while their parts come in.
struct GridParts {
  FloatGrid::Ptr surface;
  FractalField field;
};

FloatGrid::Ptr partNamed(const VdbFile& file, const char* name) {
  for (const auto& grid : file.grids)
    if (grid->getName() == name) return openvdb::gridPtrCast<FloatGrid>(grid);
  return nullptr;
}

GridParts readGrids(const fs::path& folder, const Manifest& manifest, Monitor& monitor) {
  const TileLattice& lattice = manifest.lattice.value();
  GridParts parts{.field = emptyField({.domain = lattice.domain,
                                       .bounded = lattice.bounded,
                                       .voxelSize = lattice.voxelSize,
                                       .window = lattice.domain,
                                       .blocks = nullptr},
                                      true)};
  monitor.begin("merging grids", manifest.tasks.size());
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

std::vector<openvdb::GridBase::Ptr> mergeGrids(const fs::path& folder, const Manifest& manifest,
                                               const FractalOptions& options, const PlanIslands* islands,
                                               const PlanAttributes* attributes, MergeResult& result,
                                               Monitor& monitor) {
  GridParts parts = readGrids(folder, manifest, monitor);
  const std::vector<std::string>& names = options.output.grids;
  const auto wants = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  if (wants("surface") || wants("density") || wants("versor") || attributes) {
    if (islands) parts.surface = keptSurface(folder, manifest, *islands, monitor);
    if (!parts.surface && result.crumbs) requireMoreThanCrumbs(*result.crumbs);
    if (!parts.surface) throw DataError("the fractal is empty: no tile has a part of its level set");
    finishLevelSet(*parts.surface);
    result.check = checkSurface(*parts.surface);
    if (!result.check.failure.empty())
      throw std::logic_error("the level set fails OpenVDB's check: " + result.check.failure);
    result.bandVoxels = parts.surface->activeVoxelCount();
  }
  if (wants("logmodulus")) fillTiles(parts.field);
  if (wants("logmodulus") && islands) dropIslands(parts.field, islands->options, monitor);
  std::vector<openvdb::GridBase::Ptr> grids;
  for (const std::string& name : names) {
    if (name == "surface") grids.push_back(parts.surface);
    if (name == "density") grids.push_back(densityGrid(*parts.surface));
    if (name == "logmodulus") grids.push_back(logModulusGrid(parts.field));
    if (name == "iterations") grids.push_back(parts.field.iterations);
    if (name == "versor")
      grids.push_back(versorGrid(*parts.surface, readPreparedScene(options, folder / kPreparedName).source(), monitor));
  }
  if (attributes)
    for (const openvdb::GridBase::Ptr& grid : attributeGrids(**attributes, *parts.surface, monitor))
      grids.push_back(grid);
  return grids;
}

void commit(OutputFiles& files, MergeResult& result) {
  for (const AtomicFile& file : files.files()) result.files.push_back(file.target());
  files.commit();
}

/// What the pieces of a plan are called that stay files of their own.
fs::path pieceOf(const fs::path& listed, std::uint64_t index, const char* extension) {
  return fs::path((listed.parent_path() / listed.stem()).string() + '.' + taskName(index) + extension);
}

/// One tile's own files, and what the index says of them.
nlohmann::json writeOneTile(const fs::path& folder, const Manifest& manifest, std::uint64_t index,
                            const fs::path& listed, const InputFiles& inputs, const PlanIslands* islands,
                            const PlanAttributes* attributes, MergeResult& result, Monitor& monitor) {
  using nlohmann::json;
  const TileLattice& lattice = manifest.lattice.value();
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
    MeshCounts counts;
    {
      MeshFiles meshes(pieceOf(listed, index, ".ply"), meshOptions(manifest, MeshFormat::Ply), attributes, false, files,
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
      VdbWriteOptions options = vdbWriteOptions(parseFractalOptions(manifest.recipe).output, manifest.metadata);
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

/// @throw CreateError  no file can be made there
void requirePlace(const fs::path& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  // A pipe is opened once only: its reader takes the end of the first writer for that of the file.
  if (type == fs::file_type::fifo || type == fs::file_type::socket) return;
  const AtomicFile claim(path);
}

}  // namespace

void requireMergeable(const fs::path& folder, const Manifest& manifest, const MergeOptions& options) {
  requireTiles(manifest);
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
    // First, so that a format that cannot hold the mesh is called that.
    const bool needsDoubles = needsDoublePositions(meshOptions(manifest, meshFormat(*options.mesh)));
    if (needsDoubles && !tilesNeedDoubles(manifest))
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

void requireMergeable(const fs::path& folder, const Manifest& manifest, const fs::path& index) {
  requireTiles(manifest);
  if (planDropsIslands(manifest) && makes(manifest, "vdb"))
    throw std::invalid_argument(
        "islands are dropped, and the distances to what is left of them are not known tile by tile; merge into one "
        "VDB, or plan again with --make ply alone");
  OutputPlaces places(planInputs(folder, manifest));
  places.claim(index);
  for (std::uint64_t task = 1; task <= manifest.tasks.size(); ++task)
    for (const char* extension : {".ply", ".vdb"}) places.claim(pieceOf(index, task, extension));
  requirePlace(index);
}

MergeResult mergePlan(const fs::path& folder, const Manifest& manifest, const MergeOptions& options, Monitor& monitor) {
  requireMergeable(folder, manifest, options);
  OutputFiles files(planInputs(folder, manifest));
  sweepPlan(folder, manifest);
  AtomicFile* const vdb = options.vdb ? &files.add(*options.vdb) : nullptr;
  MergeResult result{.crumbs = requireDone(folder, manifest, monitor)};
  const std::optional<PlanIslands> joined = joinIslands(folder, manifest, monitor);
  const PlanIslands* const islands = joined ? &*joined : nullptr;
  if (islands) result.islands = islands->joined.report;
  const std::unique_ptr<const PlanAttributes> attributes = planAttributes(folder, manifest);
  if (options.mesh) {
    result.mesh = mergeMesh(folder, manifest, options, islands, attributes.get(), files, monitor);
    if (result.mesh.triangles == 0 && result.crumbs) requireMoreThanCrumbs(*result.crumbs);
    if (result.mesh.triangles == 0)
      throw DataError("the fractal is empty: no tile has a triangle; plan again with less detail or smaller voxels");
  }
  if (vdb) {
    const FractalOptions recipe = parseFractalOptions(manifest.recipe);
    const std::vector<openvdb::GridBase::Ptr> grids =
        mergeGrids(folder, manifest, recipe, islands, attributes.get(), result, monitor);
    monitor.begin("writing", 0);
    vdb->stream() << encodeVdb(grids, vdbWriteOptions(recipe.output, manifest.metadata));
  }
  monitor.throwIfCancelled();
  commit(files, result);
  return result;
}

MergeResult writeTileFiles(const fs::path& folder, const Manifest& manifest, const fs::path& index, Monitor& monitor) {
  requireMergeable(folder, manifest, index);
  const InputFiles inputs = planInputs(folder, manifest);
  OutputFiles files(inputs);
  AtomicFile& file = files.add(index);
  sweepPlan(folder, manifest);
  MergeResult result{.crumbs = requireDone(folder, manifest, monitor)};
  const std::optional<PlanIslands> islands = joinIslands(folder, manifest, monitor);
  if (islands) result.islands = islands->joined.report;
  const std::unique_ptr<const PlanAttributes> attributes = planAttributes(folder, manifest);
  const TileLattice& lattice = manifest.lattice.value();
  nlohmann::ordered_json root = {{"juliavdb", "tiles"},
                                 {"version", manifest.version},
                                 {"voxel_size", lattice.voxelSize},
                                 {"recipe", manifest.metadata}};
  nlohmann::json tiles = nlohmann::json::array();
  for (std::uint64_t i = 1; i <= manifest.tasks.size(); ++i) {
    tiles.push_back(writeOneTile(folder, manifest, i, index, inputs, islands ? &*islands : nullptr, attributes.get(),
                                 result, monitor));
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
