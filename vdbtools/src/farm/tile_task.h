// SPDX-License-Identifier: Apache-2.0
/// @file tile_task.h
/// The task of a tile: its mesh (tile_file.h), its part of the grids, and, if islands are to be dropped, its islands
/// (tile_islands.h).
#pragma once

#include "farm/tile_file.h"
#include "farm/tile_islands.h"
#include "farm/tile_layers.h"

#include "vdbtools/farm/task.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/scene/grid_plan.h"
#include "vdbtools/scene/scene.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbtools::farm {

/// The names of a plan's files, relative to its folder.
inline constexpr const char* kPreparedName = "prepared.vdb";
std::string tileMeshName(std::uint64_t index);
std::string tileGridsName(std::uint64_t index);
std::string tileIslandsName(std::uint64_t index);
std::string tileCountName(std::uint64_t index);

/// The names under which a tile's TaskCounts hold a CrumbReport.
inline constexpr const char* kCrumbsCount = "crumbs";
inline constexpr const char* kCrumbNodesCount = "crumbNodes";

/// Which files the tasks of a plan write. If islands are dropped, the distances of a level set are those to the
/// remaining mesh. They are computed when the tiles are merged, and the tiles store the mesh for that.
struct TileFiles {
  bool mesh = false, grids = false, islands = false;
  bool count = false;       ///< instead of them (tile_count.h)
  bool cappedMesh = false;  ///< the mesh is stored for a level set: in doubles, and closed by caps
};

/// The files for the manifest's products. Its tasks may be missing still.
TileFiles tileFiles(const Manifest& manifest, const FractalOptions& options);

/// A plan of tiles with its recipe as values, for its tasks and their merging.
struct TileJob {
  const Manifest& manifest;
  FractalOptions options;
  GridPlan grids;   ///< empty if the plan makes no VDB
  TileFiles files;  ///< of each task

  const TileLattice& lattice() const { return manifest.lattice.value(); }
};

/// @param manifest  a plan of tiles; must outlive the result
TileJob tileJob(const Manifest& manifest);

/// The names of these files of task @a index, in the order of PlannedTask::writes.
std::vector<std::string> tileNames(const TileFiles& files, std::uint64_t index);

/// @param makes  the final products, as Manifest::makes
/// @throw std::invalid_argument  a fractal with these options cannot be cut into tiles or, if the plan counts, its
///                               tiles cannot be counted one by one
void requireCuttable(const FractalOptions& options, const std::vector<std::string>& makes);

/// How far a tile's level set depends on nodes of other tiles, in nodes.
inline constexpr int kTileHalo = 5;
/// The same for its mesh: a normal depends on the triangles in the cells around an edge.
inline constexpr int kMeshHalo = 2;

/// The nodes of a tile for points, triangles and grids: if the domain ends at a face of its box, they include the nodes
/// beyond, where caps and bands lie.
openvdb::CoordBBox ownNodes(const openvdb::CoordBBox& box, const openvdb::CoordBBox& domain);

/// The products of a tile in addition to the layers of its mesh.
struct Tile {
  std::vector<openvdb::GridBase::Ptr> grids;  ///< the tile's parts of the requested grids that are made of parts
  std::optional<TileIslands> islands;         ///< if islands are to be dropped
  std::uint64_t evaluatedNodes = 0;
  std::optional<CrumbReport> crumbs{};  ///< for the nodes that the tile owns, if crumbs are dropped
};

/// Makes a tile. Without grids and islands it is made in layers of blocks, and is never in memory as a whole.
/// @param box     the nodes that the tile owns
/// @param layers  takes the layers of the mesh, if the tile has one
Tile makeTile(const Scene& scene, const openvdb::CoordBBox& box, const FractalProducts& wanted,
              const TileLayerSink& layers, Monitor& monitor);

/// Runs the tasks of one plan one after another; what they share is read once.
class TileMaker {
 public:
  /// @param folder, manifest  of a plan of tiles
  TileMaker(std::filesystem::path folder, const Manifest& manifest);
  TileMaker(const TileMaker&) = delete;
  TileMaker& operator=(const TileMaker&) = delete;

  /// Makes the files of task @a index, and commits all of them together. The first task checks the map's files, and
  /// reads the prepared scene.
  /// @throw DataError  the scene does not belong to the plan, or a file of the map differs from the recipe's hash
  /// @throw as readPreparedScene(); CreateError, IoError
  TaskCounts make(std::uint64_t index, Monitor& monitor);

 private:
  const Scene& scene();

  std::filesystem::path mFolder;
  Manifest mManifest;
  TileJob mJob;
  std::optional<Scene> mScene;
};

/// Whether the mesh of a plan must be stored in doubles until it is merged.
bool tilesNeedDoubles(const TileJob& job);

}  // namespace vdbtools::farm
