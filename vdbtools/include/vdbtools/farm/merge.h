// SPDX-License-Identifier: Apache-2.0
/// @file merge.h
/// The tiles of a plan put together again.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/field/crumbs.h"
#include "vdbtools/field/islands.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace vdbtools::farm {

/// Many readers of PLY count points in 32 bits with a sign.
inline constexpr std::uint64_t kMostMeshPoints = 0x7fffffff;

struct MergeOptions {
  std::optional<std::filesystem::path> vdb;   ///< the grids
  std::optional<std::filesystem::path> mesh;  ///< PLY, OBJ or STL
  /// A mesh of more points is cut into files called F.1.ply, F.2.ply and so on. The points of the layer of blocks where
  /// it is cut are in both.
  std::uint64_t mostPoints = kMostMeshPoints;
};

struct MergeResult {
  std::vector<std::filesystem::path> files;  ///< that were written
  MeshCounts mesh;                           ///< of all mesh files together
  LevelSetCheck check;                       ///< of the grid "surface", if it was made
  std::uint64_t bandVoxels = 0;              ///< of the same
  std::optional<IslandReport> islands;       ///< if any were to be dropped
  std::optional<CrumbReport> crumbs;         ///< that the tiles have dropped, if they were to
};

/// What mergePlan() checks before it looks at a task: that the plan's tasks make what these files need, that the files
/// can be made where they are to be, and that none of them replaces an input or a file of the plan. Leaves nothing
/// behind.
/// @throw std::invalid_argument, CreateError  as mergePlan()
void requireMergeable(const std::filesystem::path& folder, const Manifest& manifest, const MergeOptions& options);
/// The same for writeTileFiles(), whose list stands for the pieces, too.
void requireMergeable(const std::filesystem::path& folder, const Manifest& manifest,
                      const std::filesystem::path& index);

/// Writes what one run of the plan's recipe would have written, byte for byte. The mesh is written while the tiles are
/// read, and memory holds two layers of their blocks; the grids are held whole, as a VDB is written whole. Where
/// islands are to be dropped they are joined over all tiles; memory then also holds the parts of islands in each tile,
/// and for a level set the mesh that is left.
/// @throw std::invalid_argument  the plan is not one of tiles, or its tasks do not make what is asked for
/// @throw DataError              tasks are not done; there is no surface; no island is left; a tile is broken
/// @throw CreateError, IoError, Interrupted
MergeResult mergePlan(const std::filesystem::path& folder, const Manifest& manifest, const MergeOptions& options,
                      Monitor& monitor);

/// For a fractal that is too large for one file: each tile as a mesh and a VDB of its own, and an index of them,
/// written last. Beside F.json there are F.0001.ply and F.0001.vdb; tiles without a triangle have no file. A mesh holds
/// the triangles that its tile owns and all of their points; meshes side by side share the points at their border.
/// Islands are dropped as by mergePlan().
/// @param index  the JSON file
/// @throw as mergePlan(); std::invalid_argument if islands are to be dropped and the plan makes grids, as the distances
/// to what is left are not known tile by tile
MergeResult writeTileFiles(const std::filesystem::path& folder, const Manifest& manifest,
                           const std::filesystem::path& index, Monitor& monitor);

}  // namespace vdbtools::farm
