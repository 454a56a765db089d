// SPDX-License-Identifier: Apache-2.0
#include "farm/tile_layers.h"

#include "field/block_layers.h"

#include <algorithm>
#include <utility>

namespace vdbtools::farm {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using NodeLeaf = openvdb::FloatTree::LeafNodeType;

Coord blockOf(const Coord& node) { return node & ~(kBlock - 1); }

std::uint16_t edgeNumber(const EdgePlace& edge) {
  return static_cast<std::uint16_t>(3 * NodeLeaf::coordToOffset(edge.node) + edge.axis);
}

template <class Value>
void append(std::vector<Value>& all, std::span<const Value> more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

TileLayers::TileLayers(const CoordBBox& own, TileIslands* islands, TileLayerSink sink)
    : mOwn(own), mIslands(islands), mSink(std::move(sink)) {}

TileLayers::Pending& TileLayers::pendingAt(std::int32_t x) {
  const auto at = std::find_if(mPending.begin(), mPending.end(), [&](const Pending& layer) { return layer.x >= x; });
  if (at != mPending.end() && at->x == x) return *at;
  return *mPending.insert(at, Pending{.x = x, .first = mPoints});
}

/// The layer of a point.
TileLayers::Pending& TileLayers::holder(std::uint64_t point) {
  return *std::find_if(mPending.rbegin(), mPending.rend(), [&](const Pending& layer) { return layer.first <= point; });
}

void TileLayers::addPoints(const PointBatch& batch, std::span<const EdgePlace> places) {
  for (std::size_t begin = 0; begin < places.size();) {
    const std::int32_t x = blockOf(places[begin].node)[0];
    std::size_t end = begin + 1;
    while (end < places.size() && blockOf(places[end].node)[0] == x) ++end;
    Pending& layer = pendingAt(x);
    append(layer.places, places.subspan(begin, end - begin));
    append(layer.positions, batch.positions.subspan(begin, end - begin));
    append(layer.normals, batch.normals.subspan(begin, end - begin));
    layer.used.resize(layer.places.size(), 0);
    mPoints += end - begin;
    begin = end;
  }
}

void TileLayers::addTriangles(std::span<const openvdb::Vec3I> triangles, const Coord& block,
                              std::span<const std::uint16_t> cells) {
  // The triangles of the layers before have come, and no others use their points.
  while (!mPending.empty() && mPending.front().x < block[0]) passOn();
  if (!mOwn.hasOverlap(CoordBBox::createCube(block, kBlock))) return;
  const bool whole = mOwn.isInside(CoordBBox::createCube(block, kBlock));
  Pending& layer = pendingAt(block[0]);
  TileLayer::Block record{block[1], block[2]};
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!whole && !mOwn.isInside(block + NodeLeaf::offsetToLocalCoord(cells[i]))) continue;
    TileLayer::Triangle triangle{cells[i]};
    for (int k = 0; k < 3; ++k) {
      Pending& from = holder(triangles[i][k]);
      const std::size_t point = triangles[i][k] - from.first;
      const EdgePlace& edge = from.places[point];
      from.used[point] = 1;
      const Coord ahead = blockOf(edge.node) - block;
      const unsigned neighbour = (ahead[0] ? 1u : 0) | (ahead[1] ? 2u : 0) | (ahead[2] ? 4u : 0);
      triangle[static_cast<std::size_t>(k) + 1] = static_cast<std::uint16_t>(edgeNumber(edge) | neighbour << kEdgeBits);
      if (mIslands && edge.cut) triangle[0] |= kOnCap;
      // No triangle belongs to two islands.
      if (mIslands && k == 0) layer.triangleParts.push_back(mIslands->partOf(edge));
    }
    layer.triangles.push_back(triangle);
    ++record.triangles;
  }
  if (record.triangles > 0) layer.blocks.push_back(record);
}

void TileLayers::finish() {
  while (!mPending.empty()) passOn();
}

/// Passes on the first layer, with the points of the tile sorted into its blocks.
void TileLayers::passOn() {
  Pending from = std::move(mPending.front());
  mPending.pop_front();
  TileLayer layer{.x = from.x, .triangles = std::move(from.triangles), .triangleParts = std::move(from.triangleParts)};
  layer.edges.reserve(from.places.size());
  layer.positions.reserve(from.places.size());
  layer.normals.reserve(from.places.size());
  std::size_t point = 0, block = 0;
  const auto blockAt = [&](std::size_t i) {
    const Coord origin = blockOf(from.places[i].node);
    return std::pair(origin[1], origin[2]);
  };
  // Both are ordered by blocks; the layer has the blocks of either.
  while (point < from.places.size() || block < from.blocks.size()) {
    const auto next = block < from.blocks.size() ? std::optional(std::pair(from.blocks[block].y, from.blocks[block].z))
                                                 : std::nullopt;
    const std::pair<int, int> at =
        point < from.places.size() && (!next || blockAt(point) <= *next) ? blockAt(point) : *next;
    TileLayer::Block record = next == at ? from.blocks[block++] : TileLayer::Block{at.first, at.second};
    for (; point < from.places.size() && blockAt(point) == at; ++point)
      if (const bool own = mOwn.isInside(from.places[point].node); own || from.used[point]) {
        addPoint(layer, from, point, own);
        ++record.points;
      }
    if (record.points > 0 || record.triangles > 0) layer.blocks.push_back(record);
  }
  if (!layer.blocks.empty()) mSink(layer);
}

void TileLayers::addPoint(TileLayer& layer, const Pending& from, std::size_t point, bool own) {
  const EdgePlace& place = from.places[point];
  std::uint16_t edge = edgeNumber(place);
  if (!own) edge |= kGuest;
  if (mIslands) {
    if (place.cut) edge |= kOnCap;
    const std::uint32_t part = mIslands->partOf(place);
    layer.pointParts.push_back(part);
    if (own) mIslands->countPoint(part, place.cut);
  }
  layer.edges.push_back(edge);
  layer.positions.push_back(from.positions[point]);
  layer.normals.push_back(from.normals[point]);
}

}  // namespace vdbtools::farm
