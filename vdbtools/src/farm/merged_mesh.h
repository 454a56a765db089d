// SPDX-License-Identifier: Apache-2.0
/// @file merged_mesh.h
/// What merging a plan makes of the meshes of its tiles: the islands that are left, attributes, and files of meshes.
#pragma once

#include "farm/tile_islands.h"
#include "farm/tile_merge.h"
#include "farm/tile_task.h"
#include "job/point_attributes.h"

#include "mesh_files/mesh_file.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/merge.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

namespace vdbtools::farm {

/// The attributes of a plan's points and voxels. No tile has them: they are computed when the tiles are merged.
class PlanAttributes {
 public:
  /// @param prepared  the file that holds the plan's distances
  PlanAttributes(const FractalOptions& options, const std::filesystem::path& prepared);

  const PointAttributes& operator*() const { return mAttributes; }
  const PointAttributes* operator->() const { return &mAttributes; }

 private:
  Scene mScene;
  PointAttributes mAttributes;
};

/// Null if none are requested.
std::unique_ptr<const PlanAttributes> planAttributes(const std::filesystem::path& folder, const TileJob& job);

/// The islands of a plan that drops some of them.
struct PlanIslands {
  IslandOptions options;
  std::vector<TileIslandsReader> tiles;
  JoinedIslands joined;
  bool capMesh = false;  ///< whether the written mesh has caps

  std::uint64_t meshPoints() const { return joined.points + (capMesh ? joined.capPoints : 0); }
};

/// Joins the islands of all tiles; empty if the plan drops none.
/// @throw DataError  as joinIslands() of tiles (tile_islands.h)
std::optional<PlanIslands> joinIslands(const std::filesystem::path& folder, const TileJob& job, Monitor& monitor);

/// How a mesh of the plan is written.
MeshWriteOptions meshOptions(const TileJob& job, const FileFormat& format);

/// Opens the mesh of a tile.
/// @param islands  to drop the other islands; may be null
/// @param caps     whether the points and triangles of caps are read, of a plan that drops islands
TileReader openTile(const std::filesystem::path& folder, std::uint64_t index, const PlanIslands* islands, bool caps);

/// How the mesh of some tiles is written.
struct PlanMesh {
  std::filesystem::path path;
  MeshWriteOptions options;
  const PlanAttributes* attributes = nullptr;  ///< of the points
  openvdb::Vec3d offset{0, 0, 0};              ///< as latticeOffset() has it
  bool numbered = false;                       ///< several files, F.1.ply and so on
};

/// Merges some tiles into a mesh file, or several numbered ones.
/// @throw as mergeTiles()
MeshCounts writeMesh(std::vector<TileReader>& tiles, const TileMergeOptions& merging, const PlanMesh& mesh,
                     OutputFiles& files, Monitor& monitor);

/// Merges all tiles into one mesh file, or several if there are more points than one is to have.
/// @param islands, attributes  may be null
MeshCounts mergeMesh(const std::filesystem::path& folder, const TileJob& job, const MergeOptions& options,
                     const PlanIslands* islands, const PlanAttributes* attributes, OutputFiles& files,
                     Monitor& monitor);

/// The mesh of the islands that are kept, closed by caps.
/// @throw DataError  more points than kMostMeshPoints
Mesh keptMesh(const std::filesystem::path& folder, const TileJob& job, const PlanIslands& islands, Monitor& monitor);

}  // namespace vdbtools::farm
