// SPDX-License-Identifier: Apache-2.0
/// @file tile_merge.h
/// Meshes of tiles into one mesh, layer by layer.
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
  /// Takes the points, too, that other tiles own: what is left out of the mesh is a tile by itself.
  bool keepGuests = false;
  /// Of a mesh. Where there are more, the next mesh begins, with the points of one layer of blocks in both.
  std::uint64_t mostPoints = 0x7fffffff;
};

/// Merges tiles into the mesh that one run would have made: the same points and triangles in the same order. Memory
/// holds two layers of blocks of all tiles.
/// @param nextMesh  gives the sink for the first mesh, and for each that follows
/// @return of all meshes together; points that are in two of them count twice
/// @throw DataError  a tile is broken, or lacks what another one refers to; one layer alone has more than mostPoints
MeshCounts mergeTiles(std::vector<TileReader>& tiles, const TileMergeOptions& options,
                      const std::function<MeshSink&()>& nextMesh, Monitor& monitor);

}  // namespace vdbtools::farm
