// SPDX-License-Identifier: Apache-2.0
/// @file merge.h
/// Merges the tiles of a plan.
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

/// Many PLY readers count points with signed 32-bit integers.
inline constexpr std::uint64_t kMostMeshPoints = 0x7fffffff;

struct MergeOptions {
  std::optional<std::filesystem::path> grids;  ///< in a format of grids that is written
  std::optional<std::filesystem::path> mesh;   ///< in one of meshes
  /// A mesh with more points is split into files called F.1.ply, F.2.ply and so on. The points of the layer of blocks
  /// at the cut are in both files.
  std::uint64_t mostPoints = kMostMeshPoints;
};

struct MergeResult {
  std::vector<std::filesystem::path> files;  ///< the written files
  MeshCounts mesh;                           ///< total of all mesh files
  LevelSetCheck check;                       ///< of the grid "surface", if it was made
  std::uint64_t bandVoxels = 0;              ///< active voxels of that grid
  std::optional<IslandReport> islands;       ///< if islands were to be dropped
  std::optional<CrumbReport> crumbs;         ///< the crumbs that the tiles dropped, if they were to
  std::vector<ClampedGrid> clamped;          ///< grids with values that were too large for a file of 16-bit floats
};

/// Checks what mergePlan() checks before it looks at a task: that the plan's tasks make what these files need, that the
/// files can be created at their paths, and that none of them replaces an input or a file of the plan. Leaves nothing
/// behind.
/// @throw std::invalid_argument, CreateError  as mergePlan()
void requireMergeable(const std::filesystem::path& folder, const Manifest& manifest, const MergeOptions& options);
/// The same checks for writeTileFiles(); the index also stands for the other files.
void requireMergeable(const std::filesystem::path& folder, const Manifest& manifest,
                      const std::filesystem::path& index);

/// Writes what one run of the plan's recipe would have written, byte for byte. The mesh is written while the tiles are
/// read, and memory holds two layers of their blocks. The grids are held as a whole, because a VDB is written as a
/// whole. If islands are to be dropped, they are joined across all tiles; memory then also holds the parts of islands
/// in each tile, and for a level set the remaining mesh.
/// @throw std::invalid_argument  the plan is not one of tiles, or its tasks do not make what is requested
/// @throw DataError              tasks are not done; there is no surface; no island is left; a tile is broken
/// @throw CreateError, IoError, Interrupted
MergeResult mergePlan(const std::filesystem::path& folder, const Manifest& manifest, const MergeOptions& options,
                      Monitor& monitor);

/// Adds up the tiles of a plan that makes counts, and writes the sums as JSON: "points", "triangles", their "box" in
/// world units, and a "sha256" by which two such runs can be compared, beside the plan's recipe.
/// @param file  the JSON file
/// @throw as mergePlan()
MergeResult mergeCounts(const std::filesystem::path& folder, const Manifest& manifest,
                        const std::filesystem::path& file, Monitor& monitor);
/// Checks what mergeCounts() checks before it looks at a task.
void requireCounts(const std::filesystem::path& folder, const Manifest& manifest, const std::filesystem::path& file);

/// Serves fractals that are too large for one file: it writes each tile as a mesh and a VDB of its own, and finally an
/// index of them. With F.json there are F.0001.ply and F.0001.vdb; tiles without a triangle have no file. A mesh holds
/// the triangles that its tile owns and all of their points; adjacent meshes share the points at their border. Islands
/// are dropped as by mergePlan().
/// @param index  the JSON file
/// @throw as mergePlan(); std::invalid_argument if islands are to be dropped and the plan makes grids, because the
///           distances to the remaining surface are not known tile by tile
MergeResult writeTileFiles(const std::filesystem::path& folder, const Manifest& manifest,
                           const std::filesystem::path& index, Monitor& monitor);

}  // namespace vdbtools::farm
