// SPDX-License-Identifier: Apache-2.0
/// @file tile_layers.h
/// The part of a window's mesh that a tile owns, in layers of blocks (tile_file.h), while the mesh is made.
#pragma once

#include "farm/tile_file.h"
#include "farm/tile_islands.h"

#include "vdbtools/surface/extract_mesh.h"

#include <openvdb/math/Coord.h>

#include <deque>
#include <functional>

namespace vdbtools::farm {

/// Takes the layers of a tile in the order of x, each when it is complete.
using TileLayerSink = std::function<void(const TileLayer&)>;

/// Keeps the points and triangles that a tile owns, and the further points that its triangles use. It holds as many
/// layers of blocks as SurfaceExtractor does.
class TileLayers final : public PlacedMeshSink {
 public:
  /// @param own      the nodes that the tile owns
  /// @param islands  counts the points of its parts; may be null
  TileLayers(const openvdb::CoordBBox& own, TileIslands* islands, TileLayerSink sink);

  void addPoints(const PointBatch& batch, std::span<const EdgePlace> places) override;
  void addTriangles(std::span<const openvdb::Vec3I> triangles, const openvdb::Coord& block,
                    std::span<const std::uint16_t> cells) override;

  /// Passes on the rest; nothing may be added afterwards.
  void finish();

 private:
  /// A layer of the window, while points or triangles of it may come.
  struct Pending {
    std::int32_t x = 0;
    std::uint64_t first = 0;  ///< index of its first point among all of the window
    std::vector<EdgePlace> places;
    std::vector<openvdb::Vec3d> positions;
    std::vector<openvdb::Vec3s> normals;
    std::vector<char> used;  ///< whether a triangle of the tile uses the point
    std::vector<TileLayer::Block> blocks;
    std::vector<TileLayer::Triangle> triangles;
    std::vector<std::uint32_t> triangleParts;
  };

  Pending& pendingAt(std::int32_t x);
  Pending& holder(std::uint64_t point);
  void passOn();
  void addPoint(TileLayer& layer, const Pending& from, std::size_t point, bool own);

  openvdb::CoordBBox mOwn;
  TileIslands* mIslands;
  TileLayerSink mSink;
  std::deque<Pending> mPending;  ///< by x
  std::uint64_t mPoints = 0;
};

}  // namespace vdbtools::farm
