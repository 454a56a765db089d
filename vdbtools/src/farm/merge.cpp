// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/merge.h"

#include "farm/tile_merge.h"
#include "farm/tile_task.h"
#include "field/block_evaluator.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/file_hash.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/job/prepared_scene.h"
#include "vdbtools/mesh/mesh_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <list>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

bool makes(const Manifest& manifest, const std::string& what) {
  return std::find(manifest.makes.begin(), manifest.makes.end(), what) != manifest.makes.end();
}
bool makesMesh(const Manifest& manifest) {
  return makes(manifest, "ply") || makes(manifest, "obj") || makes(manifest, "stl");
}

void requireTiles(const Manifest& manifest) {
  if (manifest.kind != PlanKind::Tiles)
    throw std::invalid_argument(
        "the plan is not one of tiles: each of its tasks makes files of its own, and nothing is to be merged");
}

/// @throw DataError  naming the tasks that are not done
void requireDone(const fs::path& folder, const Manifest& manifest, Monitor& monitor) {
  monitor.begin("checking", manifest.tasks.size());
  std::vector<std::uint64_t> missing;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    if (!finishedTask(folder, manifest, index, FileCheck::Content)) missing.push_back(index);
    monitor.advance(1);
    monitor.throwIfCancelled();
  }
  if (!missing.empty())
    throw DataError((missing.size() == 1 ? "task " : "tasks ") + taskList(missing) + " of " +
                    std::to_string(manifest.tasks.size()) + (missing.size() == 1 ? " is" : " are") +
                    " not done, or not as the plan has them; run them and merge again");
}

MeshWriteOptions meshOptions(const Manifest& manifest, MeshFormat format) {
  const TileLattice& lattice = manifest.lattice.value();
  return {.format = format,
          .voxelSize = lattice.voxelSize,
          .box = meshBox({.domain = lattice.domain, .voxelSize = lattice.voxelSize}),
          .comments = manifest.facts};
}

/// Meshes that begin when they are asked for: one file, or several with numbers.
class MeshFiles {
 public:
  MeshFiles(const fs::path& path, const MeshWriteOptions& options, bool numbered, std::list<AtomicFile>& files)
      : mPath(path), mOptions(options), mNumbered(numbered), mFiles(files) {}

  MeshSink& next() {
    if (!mMeshes.empty()) mMeshes.back().finish();
    fs::path path = mPath;
    if (mNumbered)
      path.replace_filename(mPath.stem().string() + '.' + std::to_string(mMeshes.size() + 1) +
                            mPath.extension().string());
    return mMeshes.emplace_back(mFiles.emplace_back(path), mOptions);
  }
  void finish() {
    if (!mMeshes.empty()) mMeshes.back().finish();
  }

 private:
  fs::path mPath;
  MeshWriteOptions mOptions;
  bool mNumbered;
  std::list<AtomicFile>& mFiles;
  std::list<MeshFile> mMeshes;
};

std::vector<TileReader> openTiles(const fs::path& folder, const Manifest& manifest) {
  std::vector<TileReader> tiles;
  tiles.reserve(manifest.tasks.size());
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index)
    tiles.emplace_back(folder / tileMeshName(index));
  return tiles;
}

MeshCounts mergeMesh(const fs::path& folder, const Manifest& manifest, const MergeOptions& options,
                     std::list<AtomicFile>& files, Monitor& monitor) {
  const MeshFormat format = meshFormat(*options.mesh);
  if (!makes(manifest, lowerExtension(*options.mesh).substr(1)) && format != MeshFormat::Ply)
    throw std::invalid_argument("the plan was made for other files than '" + options.mesh->string() +
                                "', whose numbers need all digits of the tiles; name the format when planning");
  std::vector<TileReader> tiles = openTiles(folder, manifest);
  std::uint64_t points = 0;
  for (const TileReader& tile : tiles) points += tile.counts().points;
  MeshFiles meshes(*options.mesh, meshOptions(manifest, format), points > options.mostPoints, files);
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
    const VdbFile file = readVdb(folder / tileGridsName(index));
    if (const FloatGrid::Ptr part = partNamed(file, "surface"); part && !part->empty()) {
      if (!parts.surface) {
        parts.surface = FloatGrid::create(part->background());
        parts.surface->setTransform(openvdb::math::Transform::createLinearTransform(lattice.voxelSize));
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
                                               const FractalOptions& options, MergeResult& result, Monitor& monitor) {
  GridParts parts = readGrids(folder, manifest, monitor);
  const std::vector<std::string>& names = options.output.grids;
  const auto wants = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  if (wants("surface") || wants("density") || wants("versor")) {
    if (!parts.surface) throw DataError("the fractal is empty: no tile has a part of its level set");
    finishLevelSet(*parts.surface);
    result.check = checkSurface(*parts.surface);
    if (!result.check.failure.empty())
      throw std::logic_error("the level set fails OpenVDB's check: " + result.check.failure);
    result.bandVoxels = parts.surface->activeVoxelCount();
  }
  if (wants("logmodulus")) fillTiles(parts.field);
  std::vector<openvdb::GridBase::Ptr> grids;
  for (const std::string& name : names) {
    if (name == "surface") grids.push_back(parts.surface);
    if (name == "density") grids.push_back(densityGrid(*parts.surface));
    if (name == "logmodulus") grids.push_back(logModulusGrid(parts.field));
    if (name == "iterations") grids.push_back(parts.field.iterations);
    if (name == "versor")
      grids.push_back(versorGrid(*parts.surface, readPreparedScene(options, folder / kPreparedName).source(), monitor));
  }
  return grids;
}

void commit(std::list<AtomicFile>& files, MergeResult& result) {
  std::vector<AtomicFile*> all;
  for (AtomicFile& file : files) {
    all.push_back(&file);
    result.files.push_back(file.target());
  }
  commitAll(all);
}

/// One tile's own files, and what the index says of them.
nlohmann::json writeOneTile(const fs::path& folder, const Manifest& manifest, std::uint64_t index, const fs::path& stem,
                            MergeResult& result, Monitor& monitor) {
  using nlohmann::json;
  const TileLattice& lattice = manifest.lattice.value();
  const openvdb::CoordBBox box = manifest.tasks[index - 1].box.value();
  const openvdb::Vec3d low = box.min().asVec3d() * lattice.voxelSize, high = box.max().asVec3d() * lattice.voxelSize;
  json entry = {{"tile", index},
                {"nodes", {box.min()[0], box.min()[1], box.min()[2], box.max()[0], box.max()[1], box.max()[2]}},
                {"box", {low[0], low[1], low[2], high[0], high[1], high[2]}},
                {"files", json::array()}};
  const auto nameOf = [&](const char* extension) {
    return fs::path(stem.string() + '.' + taskName(index) + extension);
  };
  std::list<AtomicFile> files;
  if (makesMesh(manifest)) {
    std::vector<TileReader> tile;
    tile.emplace_back(folder / tileMeshName(index));
    const TileCounts counts = tile.front().counts();
    entry["points"] = counts.points + counts.guests;
    entry["triangles"] = counts.triangles;
    if (counts.triangles > 0) {
      MeshFiles meshes(nameOf(".ply"), meshOptions(manifest, MeshFormat::Ply), false, files);
      const std::function<MeshSink&()> next = [&]() -> MeshSink& { return meshes.next(); };
      mergeTiles(tile, {.keepGuests = true}, next, monitor);
      meshes.finish();
      result.mesh.points += counts.points + counts.guests;
      result.mesh.triangles += counts.triangles;
    }
  }
  if (makes(manifest, "vdb")) {
    const VdbFile file = readVdb(folder / tileGridsName(index));
    if (const FloatGrid::Ptr part = partNamed(file, "surface"); part && !part->empty()) {
      finishLevelSet(*part);
      entry["band_voxels"] = part->activeVoxelCount();
      result.bandVoxels += part->activeVoxelCount();
      files.emplace_back(nameOf(".vdb")).stream() << encodeVdb({part}, {.metadata = manifest.facts});
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

}  // namespace

MergeResult mergePlan(const fs::path& folder, const Manifest& manifest, const MergeOptions& options, Monitor& monitor) {
  requireTiles(manifest);
  if (!options.vdb && !options.mesh) throw std::invalid_argument("no file was named for what is merged");
  if (options.vdb && !makes(manifest, "vdb"))
    throw std::invalid_argument("the tasks of the plan make no grids; plan again with them");
  if (options.mesh && !makesMesh(manifest))
    throw std::invalid_argument("the tasks of the plan make no mesh; plan again with one");
  sweepPlan(folder, manifest);
  std::list<AtomicFile> files;
  AtomicFile* const vdb = options.vdb ? &files.emplace_back(*options.vdb) : nullptr;
  requireDone(folder, manifest, monitor);
  MergeResult result;
  if (options.mesh) {
    result.mesh = mergeMesh(folder, manifest, options, files, monitor);
    if (result.mesh.triangles == 0)
      throw DataError("the fractal is empty: no tile has a triangle; plan again with less detail or smaller voxels");
  }
  if (vdb) {
    const FractalOptions recipe = parseFractalOptions(manifest.recipe);
    const std::vector<openvdb::GridBase::Ptr> grids = mergeGrids(folder, manifest, recipe, result, monitor);
    monitor.begin("writing", 0);
    vdb->stream() << encodeVdb(grids, {.half = recipe.output.half, .metadata = manifest.facts});
  }
  monitor.throwIfCancelled();
  commit(files, result);
  return result;
}

MergeResult writeTileFiles(const fs::path& folder, const Manifest& manifest, const fs::path& index, Monitor& monitor) {
  requireTiles(manifest);
  sweepPlan(folder, manifest);
  AtomicFile file(index);
  requireDone(folder, manifest, monitor);
  MergeResult result;
  const TileLattice& lattice = manifest.lattice.value();
  nlohmann::ordered_json root = {{"juliavdb", "tiles"},
                                 {"version", manifest.version},
                                 {"voxel_size", lattice.voxelSize},
                                 {"recipe", manifest.facts}};
  nlohmann::json tiles = nlohmann::json::array();
  const fs::path stem = index.parent_path() / index.stem();
  for (std::uint64_t i = 1; i <= manifest.tasks.size(); ++i) {
    tiles.push_back(writeOneTile(folder, manifest, i, stem, result, monitor));
    monitor.throwIfCancelled();
  }
  if (result.files.empty()) throw DataError("the fractal is empty: no tile has a surface");
  root["points"] = result.mesh.points;
  root["triangles"] = result.mesh.triangles;
  root["tiles"] = std::move(tiles);
  file.stream() << root.dump(1) << '\n';
  file.commit();
  result.files.push_back(index);
  return result;
}

}  // namespace vdbtools
