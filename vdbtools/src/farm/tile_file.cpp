// SPDX-License-Identifier: Apache-2.0
#include "farm/tile_file.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>
#include <utility>

namespace vdbtools::farm {
namespace {

static_assert(std::endian::native == std::endian::little, "tiles are written as numbers lie in memory");
static_assert(sizeof(openvdb::Vec3d) == 24 && sizeof(openvdb::Vec3s) == 12 && sizeof(TileLayer::Block) == 16 &&
              sizeof(TileLayer::Triangle) == 8);

constexpr std::string_view kMagic = "JVDBTILE";
constexpr std::uint32_t kVersion = 1;

struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint16_t coordinate, parts;
  std::uint64_t points, guests, triangles, layers;
};
static_assert(sizeof(Header) == 48);

struct LayerHead {
  std::int32_t x;
  std::uint32_t blocks;
};

template <class Value>
void put(std::string& bytes, const std::vector<Value>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
}

}  // namespace

void TileEncoder::add(const TileLayer& layer) {
  for (const std::uint16_t edge : layer.edges) ++(edge & kGuest ? mCounts.guests : mCounts.points);
  mCounts.triangles += layer.triangles.size();
  ++mCounts.layers;
  mParts = mParts || !layer.pointParts.empty();
  const std::size_t coordinate = mDoubles ? sizeof(double) : sizeof(float);
  std::string& bytes = mLayers.emplace_back();
  bytes.reserve(sizeof(LayerHead) + layer.blocks.size() * sizeof(TileLayer::Block) +
                layer.edges.size() * (sizeof(std::uint16_t) + 3 * coordinate + sizeof(openvdb::Vec3s)) +
                layer.triangles.size() * sizeof(TileLayer::Triangle) +
                (layer.pointParts.size() + layer.triangleParts.size()) * sizeof(std::uint32_t));
  put(bytes, std::vector{LayerHead{layer.x, static_cast<std::uint32_t>(layer.blocks.size())}});
  put(bytes, layer.blocks);
  put(bytes, layer.edges);
  if (mDoubles)
    put(bytes, layer.positions);
  else
    put(bytes, std::vector<openvdb::Vec3s>(layer.positions.begin(), layer.positions.end()));
  put(bytes, layer.normals);
  put(bytes, layer.triangles);
  put(bytes, layer.pointParts);
  put(bytes, layer.triangleParts);
}

void TileEncoder::write(std::ostream& stream) const {
  Header header{.magic = {},
                .version = kVersion,
                .coordinate = static_cast<std::uint16_t>(mDoubles ? sizeof(double) : sizeof(float)),
                .parts = static_cast<std::uint16_t>(mParts ? 1 : 0),
                .points = mCounts.points,
                .guests = mCounts.guests,
                .triangles = mCounts.triangles,
                .layers = mCounts.layers};
  std::memcpy(header.magic, kMagic.data(), kMagic.size());
  stream.write(reinterpret_cast<const char*>(&header), sizeof header);
  for (const std::string& layer : mLayers) stream.write(layer.data(), static_cast<std::streamsize>(layer.size()));
}

bool applyFilter(const TileFilter& filter, TileLayer& layer) {
  const auto known = [&](std::uint32_t part) { return part < filter.keptParts.size(); };
  if (!std::all_of(layer.pointParts.begin(), layer.pointParts.end(), known) ||
      !std::all_of(layer.triangleParts.begin(), layer.triangleParts.end(), known))
    return false;
  std::size_t point = 0, triangle = 0, points = 0, triangles = 0;  // read, and kept
  for (TileLayer::Block& block : layer.blocks) {
    const std::size_t pointsEnd = point + block.points, trianglesEnd = triangle + block.triangles;
    const std::size_t pointsBefore = points, trianglesBefore = triangles;
    for (; point < pointsEnd; ++point) {
      const std::uint16_t edge = layer.edges[point];
      if (!filter.keptParts[layer.pointParts[point]] || (edge & kOnCap && !filter.caps)) continue;
      layer.edges[points] = static_cast<std::uint16_t>(edge & ~kOnCap);
      layer.positions[points] = layer.positions[point];
      layer.normals[points++] = layer.normals[point];
    }
    for (; triangle < trianglesEnd; ++triangle) {
      TileLayer::Triangle record = layer.triangles[triangle];
      if (!filter.keptParts[layer.triangleParts[triangle]] || (record[0] & kOnCap && !filter.caps)) continue;
      record[0] = static_cast<std::uint16_t>(record[0] & ~kOnCap);
      layer.triangles[triangles++] = record;
    }
    block.points = static_cast<std::uint32_t>(points - pointsBefore);
    block.triangles = static_cast<std::uint32_t>(triangles - trianglesBefore);
  }
  std::erase_if(layer.blocks, [](const TileLayer::Block& block) { return block.points == 0 && block.triangles == 0; });
  layer.edges.resize(points);
  layer.positions.resize(points);
  layer.normals.resize(points);
  layer.triangles.resize(triangles);
  layer.pointParts.clear();
  layer.triangleParts.clear();
  return true;
}

TileReader::TileReader(const std::filesystem::path& path) : mPath(path), mStream(openToRead(path)) {
  std::error_code error;
  mLeft = std::filesystem::file_size(path, error);
  if (error) throw MissingInputError("cannot open the tile '" + inOneLine(path.string()) + "'");
  Header header{};
  read(&header, sizeof header);
  if (std::string_view(header.magic, kMagic.size()) != kMagic || header.version != kVersion ||
      (header.coordinate != 4 && header.coordinate != 8) || header.parts > 1)
    refuse("it is not a tile of this version");
  mDoubles = header.coordinate == 8;
  mHasParts = header.parts == 1;
  mCounts = {header.points, header.guests, header.triangles, header.layers};
  readX();
  mPosition = mStream.tellg();
  mStream.close();
}

void TileReader::setFilter(TileFilter filter) {
  // A tile without a layer does not show it.
  if (!mHasParts && mCounts.layers > 0) refuse("it has no parts of islands");
  mFilter = std::move(filter);
}

void TileReader::refuse(const char* why) const {
  throw DataError("the tile '" + inOneLine(mPath.string()) + "' cannot be used: " + why);
}

void TileReader::read(void* to, std::size_t bytes) {
  if (bytes > mLeft) refuse("it is truncated");
  mLeft -= bytes;
  mStream.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
  if (!mStream) throw IoError("reading '" + inOneLine(mPath.string()) + "' broke off");
}

void TileReader::readX() {
  mNextX.reset();
  if (mRead == mCounts.layers) return;
  std::int32_t x = 0;
  read(&x, sizeof x);
  mNextX = x;
}

TileLayer TileReader::next() {
  TileLayer layer{.x = mNextX.value()};
  if (!mStream.is_open()) {
    mStream = openToRead(mPath);
    if (!mStream.seekg(mPosition)) throw MissingInputError("cannot open the tile '" + inOneLine(mPath.string()) + "'");
  }
  std::uint32_t blocks = 0;
  read(&blocks, sizeof blocks);
  // Counts are compared with the rest of the file before memory is allocated for them.
  const auto take = [&](auto& values, std::uint64_t count) {
    using Value = typename std::remove_reference_t<decltype(values)>::value_type;
    if (count > mLeft / sizeof(Value)) refuse("it is truncated");
    values.resize(count);
    read(values.data(), count * sizeof(Value));
  };
  take(layer.blocks, blocks);
  std::uint64_t points = 0, triangles = 0;
  for (const TileLayer::Block& block : layer.blocks) {
    points += block.points;
    triangles += block.triangles;
  }
  take(layer.edges, points);
  if (mDoubles) {
    take(layer.positions, points);
  } else {
    std::vector<openvdb::Vec3s> floats;
    take(floats, points);
    layer.positions.assign(floats.begin(), floats.end());
  }
  take(layer.normals, points);
  take(layer.triangles, triangles);
  if (mHasParts) {
    take(layer.pointParts, points);
    take(layer.triangleParts, triangles);
  }
  if (mFilter && !applyFilter(*mFilter, layer)) refuse("a point belongs to a part of an island that is not there");
  ++mRead;
  readX();
  if (!mNextX) mStream.close();
  return layer;
}

}  // namespace vdbtools::farm
