// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/merge.h"

#include "farm/merged_grids.h"
#include "farm/merged_mesh.h"
#include "farm/tile_count.h"
#include "farm/tile_task.h"

#include "mesh_files/mesh_file.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/job/fractal_job.h"

#include <nlohmann/json.hpp>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;

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
    MeshCounts counts = writeMesh(tile, {.keepGuests = true},
                                  {.path = pieceOf(listed, index, ".ply"),
                                   .options = meshOptions(job, meshFormat(".ply")),
                                   .attributes = attributes,
                                   .offset = latticeOffset(job.options, lattice.voxelSize)},
                                  files, monitor);
    if (counts.triangles == 0) {
      files.clear();
      counts = {};
    }
    entry["points"] = counts.points;
    entry["triangles"] = counts.triangles;
    result.mesh.points += counts.points;
    result.mesh.triangles += counts.triangles;
  }
  if (makesGrids(manifest)) {
    const VdbFile file = readVdb(folder / tileGridsName(index));
    if (const openvdb::FloatGrid::Ptr part = partNamed(file, "surface"); part && !part->empty()) {
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
  if (!options.grids && !options.mesh) throw std::invalid_argument("no file was named for what is merged");
  if (options.grids) gridFormat(*options.grids);
  if (options.grids && !makesGrids(manifest))
    throw std::invalid_argument("the tasks of the plan make no grids, so '" + inOneLine(options.grids->native()) +
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
  for (const std::optional<fs::path>& file : {options.grids, options.mesh})
    if (file) {
      places.claim(*file);
      requirePlace(*file);
    }
}

void requireMergeable(const fs::path& folder, const TileJob& job, const fs::path& index) {
  const Manifest& manifest = job.manifest;
  if (makesGrids(manifest) && job.files.islands)
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
  AtomicFile* const gridFile = options.grids ? &files.add(*options.grids) : nullptr;
  MergeResult result{.crumbs = requireDone(folder, job, monitor)};
  const std::optional<PlanIslands> joined = joinIslands(folder, job, monitor);
  const PlanIslands* const islands = joined ? &*joined : nullptr;
  if (islands) result.islands = islands->joined.report;
  const std::unique_ptr<const PlanAttributes> attributes = planAttributes(folder, job);
  if (options.mesh) {
    result.mesh = mergeMesh(folder, job, options, islands, attributes.get(), files, monitor);
    requireTriangles(result);
  }
  if (gridFile) {
    const std::vector<openvdb::GridBase::Ptr> grids =
        mergeGrids(folder, job, islands, attributes.get(), result, monitor);
    monitor.begin(PhaseKind::Writing, 0);
    VdbWriteOptions write = vdbWriteOptions(job.options.output, manifest.metadata);
    write.clamped = &result.clamped;
    writeGrids(gridFile->stream(), gridFormat(*options.grids), grids, write);
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
