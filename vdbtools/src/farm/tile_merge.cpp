// SPDX-License-Identifier: Apache-2.0
#include "farm/tile_merge.h"

#include "field/block_layers.h"

#include "vdbtools/base/errors.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools::farm {
namespace {

using openvdb::Index;
using openvdb::Vec3d;
using openvdb::Vec3s;

using Place = std::pair<std::int32_t, std::int32_t>;  // y and z of a block

/// A block's range in the points of a layer, or in its triangles.
struct Block {
  std::uint64_t first = 0;                     ///< of the layer's points
  std::vector<std::uint16_t> edges;            ///< ascending
  std::vector<TileLayer::Triangle> triangles;  ///< by cells
};

/// A layer of the merged mesh.
struct Layer {
  std::int32_t x = 0;
  std::map<Place, Block> blocks;
  std::vector<Vec3d> positions;
  std::vector<Vec3s> normals;
};

/// The part of a block in one tile.
struct Part {
  const TileLayer* layer;
  std::size_t point, points, triangle, triangles;
};

[[noreturn]] void refuseBlock(std::int32_t x, const Place& place, const char* what) {
  throw DataError("the tiles do not fit together: the block at node " + std::to_string(x) + ", " +
                  std::to_string(place.first) + ", " + std::to_string(place.second) + " " + what +
                  "; make the tiles again");
}

/// Sorts the parts of one block: points by their edges, triangles by their cells.
void addBlock(const Place& place, const std::vector<Part>& parts, bool keepGuests, Layer& layer) {
  struct Point {
    std::uint16_t edge;
    const TileLayer* from;
    std::size_t at;
  };
  std::vector<Point> points;
  Block block{.first = layer.positions.size()};
  for (const Part& part : parts) {
    for (std::size_t i = part.point; i < part.point + part.points; ++i) {
      const std::uint16_t edge = part.layer->edges[i];
      if (keepGuests || !(edge & kGuest))
        points.push_back({static_cast<std::uint16_t>(edge & kEdgeMask), part.layer, i});
    }
    const auto first = part.layer->triangles.begin() + static_cast<std::ptrdiff_t>(part.triangle);
    block.triangles.insert(block.triangles.end(), first, first + static_cast<std::ptrdiff_t>(part.triangles));
  }
  if (parts.size() > 1) {
    std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.edge < b.edge; });
    // The triangles of a cell are all in one tile, and keep their order.
    std::stable_sort(block.triangles.begin(), block.triangles.end(),
                     [](const auto& a, const auto& b) { return a[0] < b[0]; });
  }
  block.edges.reserve(points.size());
  for (const Point& point : points) {
    if (!block.edges.empty() && point.edge <= block.edges.back()) refuseBlock(layer.x, place, "has a point twice");
    block.edges.push_back(point.edge);
    layer.positions.push_back(point.from->positions[point.at]);
    layer.normals.push_back(point.from->normals[point.at]);
  }
  layer.blocks.emplace_hint(layer.blocks.end(), place, std::move(block));
}

/// Reads the layer at @a x of all tiles that have it.
Layer readLayer(std::vector<TileReader>& tiles, std::int32_t x, bool keepGuests) {
  std::vector<TileLayer> layers;
  for (TileReader& tile : tiles)
    if (tile.nextX() == x) layers.push_back(tile.next());
  std::map<Place, std::vector<Part>> parts;
  for (const TileLayer& layer : layers) {
    std::size_t point = 0, triangle = 0;
    for (const TileLayer::Block& block : layer.blocks) {
      parts[{block.y, block.z}].push_back({&layer, point, block.points, triangle, block.triangles});
      point += block.points;
      triangle += block.triangles;
    }
  }
  Layer merged{.x = x};
  for (const auto& [place, of] : parts) addBlock(place, of, keepGuests, merged);
  return merged;
}

/// Writes merged layers into meshes.
class LayerWriter {
 public:
  LayerWriter(const TileMergeOptions& options, const std::function<MeshSink&()>& nextMesh)
      : mOptions(options), mNextMesh(nextMesh) {}

  void add(Layer layer) {
    if (mBefore && layer.x != mBefore->x + kBlock) finishLayer(nullptr);
    const std::uint64_t points = layer.positions.size();
    if (mSink && mPoints + points > mOptions.mostPoints) {
      // The previous layer begins a new mesh, because its triangles use points of both.
      mSink = nullptr;
      if (mBefore) mBeforeFirst = beginLayer(*mBefore);
    }
    const std::uint64_t first = beginLayer(layer);
    if (mBefore) finishLayer(&layer, first);
    mBefore = std::move(layer);
    mBeforeFirst = first;
  }

  MeshCounts finish() {
    if (mBefore) finishLayer(nullptr);
    return mCounts;
  }

 private:
  /// The edges of a block and of its next neighbours, as corners refer to them, and the index of the first point of
  /// each.
  using Around = std::array<std::pair<const std::vector<std::uint16_t>*, std::uint64_t>, 8>;

  /// Adds a layer's points. @return the index of the first one in its mesh
  std::uint64_t beginLayer(const Layer& layer) {
    if (!mSink) {
      mSink = &mNextMesh();
      mPoints = 0;
    }
    const std::uint64_t first = mPoints, count = layer.positions.size();
    if (first + count > mOptions.mostPoints)
      throw DataError("two layers of blocks have " + std::to_string(first + count) +
                      " points, more than one mesh is to have, " + std::to_string(mOptions.mostPoints) +
                      "; merge into files of the tiles instead");
    if (count > 0) mSink->addPoints({layer.positions, layer.normals});
    mPoints += count;
    mCounts.points += count;
    return first;
  }

  /// Adds the triangles of the previous layer, which may use points of the next one.
  void finishLayer(const Layer* next, std::uint64_t nextFirst = 0) {
    const Layer& layer = *mBefore;
    std::vector<openvdb::Vec3I> triangles;
    for (const auto& [place, block] : layer.blocks) {
      triangles.clear();
      Around around{};
      for (unsigned ahead = 0; ahead < around.size() && !block.triangles.empty(); ++ahead) {
        const Layer* const of = ahead & 1 ? next : &layer;
        if (!of) continue;
        const auto found =
            of->blocks.find({place.first + (ahead & 2 ? kBlock : 0), place.second + (ahead & 4 ? kBlock : 0)});
        if (found == of->blocks.end()) continue;
        around[ahead] = {&found->second.edges, (ahead & 1 ? nextFirst : mBeforeFirst) + found->second.first};
      }
      for (const TileLayer::Triangle& t : block.triangles) {
        openvdb::Vec3I corners;
        for (unsigned k = 0; k < 3; ++k) {
          const std::optional<Index> index = indexOf(t[k + 1], around);
          if (!index) refuseBlock(layer.x, place, "has a triangle with a corner that no tile has");
          corners[static_cast<int>(k)] = *index;
        }
        triangles.push_back(corners);
      }
      if (!triangles.empty()) mSink->addTriangles(triangles, mBeforeFirst);
      mCounts.triangles += triangles.size();
    }
    mBefore.reset();
  }

  static std::optional<Index> indexOf(std::uint16_t corner, const Around& around) {
    const auto& [edges, first] = around[corner >> kEdgeBits & 7u];
    if (!edges) return std::nullopt;
    const auto edge = static_cast<std::uint16_t>(corner & kEdgeMask);
    const auto at = std::lower_bound(edges->begin(), edges->end(), edge);
    if (at == edges->end() || *at != edge) return std::nullopt;
    return static_cast<Index>(first + static_cast<std::uint64_t>(at - edges->begin()));
  }

  TileMergeOptions mOptions;
  const std::function<MeshSink&()>& mNextMesh;
  MeshSink* mSink = nullptr;
  std::uint64_t mPoints = 0;  ///< of the current mesh
  std::optional<Layer> mBefore;
  std::uint64_t mBeforeFirst = 0;  ///< the index of its first point in the current mesh
  MeshCounts mCounts;
};

}  // namespace

MeshCounts mergeTiles(std::vector<TileReader>& tiles, const TileMergeOptions& options,
                      const std::function<MeshSink&()>& nextMesh, Monitor& monitor) {
  if (options.mostPoints > std::numeric_limits<Index>::max())
    throw std::invalid_argument("a mesh of up to " + std::to_string(options.mostPoints) +
                                " points is asked for, and triangles can refer to " +
                                std::to_string(std::numeric_limits<Index>::max()) + " of them");
  std::uint64_t layers = 0;
  for (const TileReader& tile : tiles) layers += tile.counts().layers;
  monitor.begin(PhaseKind::Merging, layers);
  LayerWriter writer(options, nextMesh);
  for (;;) {
    std::optional<std::int32_t> x;
    std::uint64_t count = 0;
    for (const TileReader& tile : tiles)
      if (tile.nextX() && (!x || *tile.nextX() < *x)) x = tile.nextX();
    if (!x) break;
    for (const TileReader& tile : tiles) count += tile.nextX() == x ? 1 : 0;
    writer.add(readLayer(tiles, *x, options.keepGuests));
    monitor.advance(count);
    monitor.throwIfCancelled();
  }
  return writer.finish();
}

}  // namespace vdbtools::farm
