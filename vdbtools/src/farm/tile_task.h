// SPDX-License-Identifier: Apache-2.0
/// @file tile_task.h
/// The task of a tile: its mesh (tile_file.h), its part of the grids, and its islands where some are to be dropped
/// (tile_islands.h).
#pragma once

#include "farm/tile_file.h"
#include "farm/tile_islands.h"

#include "vdbtools/farm/task.h"
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

/// Of a tile's TaskCounts: CrumbReport.
inline constexpr const char* kCrumbsCount = "crumbs";
inline constexpr const char* kCrumbNodesCount = "crumbNodes";

/// Which files the tasks of a plan write. Where islands are dropped the distances of a level set are those to what is
/// left of the mesh. They are computed when the tiles are merged, and the tiles hold the mesh for that.
struct TileFiles {
  bool mesh = false, grids = false, islands = false;
  bool cappedMesh = false;  ///< the mesh is kept for a level set: in doubles, and closed by caps
};

/// Of what the manifest makes. Its tasks need not be there yet.
TileFiles tileFiles(const Manifest& manifest, const FractalOptions& options);

/// The names of these files of task @a index, in the order of PlannedTask::writes.
std::vector<std::string> tileNames(const TileFiles& files, std::uint64_t index);

/// @throw std::invalid_argument  options that a fractal in tiles cannot have
void requireCuttable(const FractalOptions& options);

/// How far a tile's level set and its normals depend on nodes of other tiles.
inline constexpr int kTileHalo = 5;

/// The nodes that are a tile's own when it comes to points, triangles and grids: where the domain ends with its box,
/// those beyond as well, as caps and bands lie there.
openvdb::CoordBBox ownNodes(const openvdb::CoordBBox& box, const openvdb::CoordBBox& domain);

struct Tile {
  std::vector<TileLayer> layers;              ///< of the mesh, if it is wanted
  std::vector<openvdb::GridBase::Ptr> grids;  ///< the parts of those that are wanted and are made of parts
  std::optional<TileIslands> islands;         ///< if some are to be dropped
  std::uint64_t evaluatedNodes = 0;
  std::optional<CrumbReport> crumbs{};  ///< of the nodes that the tile owns, if they are dropped
};

/// @param box  the nodes that the tile owns
Tile makeTile(const Scene& scene, const openvdb::CoordBBox& box, bool wantsMesh, bool wantsGrids, Monitor& monitor);

TaskCounts makeTile(const std::filesystem::path& folder, const Manifest& manifest, std::uint64_t index,
                    Monitor& monitor);

/// Whether the mesh of a plan has to keep doubles until it is merged.
bool tilesNeedDoubles(const Manifest& manifest);

}  // namespace vdbtools::farm
