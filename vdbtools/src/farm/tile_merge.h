// SPDX-License-Identifier: Apache-2.0
/// @file tile_merge.h
/// Merges the meshes of tiles into one mesh, layer by layer.
#pragma once

#include "farm/tile_file.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/surface/extract_mesh.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace vdbtools::farm {

struct TileMergeOptions {
  /// Whether to include the points that other tiles own, for the mesh of a single tile.
  bool keepGuests = false;
  /// The maximum number of points of a mesh. If there are more, the next mesh begins, with the points of one layer of
  /// blocks in both.
  std::uint64_t mostPoints = 0x7fffffff;
};

/// Merges tiles into the mesh that one run would have made: the same points and triangles in the same order. Memory
/// holds two layers of blocks of all tiles.
/// @param nextMesh  returns the sink for the first mesh, and for each following mesh
/// @return the totals of all meshes; points that are in two of them count twice
/// @throw std::invalid_argument  more points to a mesh than 32 bits count
/// @throw DataError  a tile is broken, or lacks a point to which another one refers; one layer alone has more than
///                   mostPoints
MeshCounts mergeTiles(std::vector<TileReader>& tiles, const TileMergeOptions& options,
                      const std::function<MeshSink&()>& nextMesh, Monitor& monitor);

}  // namespace vdbtools::farm
