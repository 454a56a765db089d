// SPDX-License-Identifier: Apache-2.0
#include "farm/tile_count.h"

#include "base/json_text.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/named_file.h"

#include <nlohmann/json.hpp>

namespace vdbtools::farm {
namespace {

using CountJson = nlohmann::ordered_json;
using openvdb::Vec3d;

constexpr std::size_t kDigits = 64;  // of a SHA-256

bool isDigest(const std::string& text) {
  return text.size() == kDigits && text.find_first_not_of("0123456789abcdef") == text.npos;
}

}  // namespace

void TileCounter::add(const TileLayer& layer) {
  mTile.add(layer);
  for (std::size_t i = 0; i < layer.positions.size(); ++i)
    if ((layer.edges[i] & kGuest) == 0) mBox.expand(layer.positions[i]);
}

TileCount TileCounter::count() const {
  HashStream stream;
  mTile.write(stream);
  const TileCounts& counts = mTile.counts();
  TileCount count{.points = counts.points, .triangles = counts.triangles, .sha256 = stream.sha256Hex()};
  if (count.points > 0) count.box = mBox;
  return count;
}

nlohmann::ordered_json jsonOf(const TileCount& count) {
  CountJson json = {{"points", count.points}, {"triangles", count.triangles}};
  if (count.box) {
    const Vec3d &low = count.box->min(), &high = count.box->max();
    json["box"] = {low[0], low[1], low[2], high[0], high[1], high[2]};
  }
  json["sha256"] = count.sha256;
  return json;
}

std::string encodeTileCount(const TileCount& count) { return jsonOf(count).dump() + '\n'; }

TileCount parseTileCount(const std::string& text) {
  try {
    const auto json = parsedJson<CountJson>(text);
    TileCount count{.sha256 = json.at("sha256").get<std::string>()};
    const auto whole = [&](const char* name) {
      if (!json.at(name).is_number_unsigned()) throw DataError(std::string("its '") + name + "' is not a count");
      return json.at(name).get<std::uint64_t>();
    };
    count.points = whole("points");
    count.triangles = whole("triangles");
    if (!isDigest(count.sha256)) throw DataError("its 'sha256' is not one");
    if (json.contains("box")) {
      const auto box = json.at("box").get<std::vector<double>>();
      if (box.size() != 6) throw DataError("its 'box' does not have 6 numbers");
      count.box = openvdb::BBoxd(Vec3d(box[0], box[1], box[2]), Vec3d(box[3], box[4], box[5]));
    }
    if (count.box.has_value() != (count.points > 0)) throw DataError("its 'box' does not fit its points");
    return count;
  } catch (const nlohmann::json::exception&) {
    throw DataError("an entry is missing or of the wrong kind");
  }
}

TileCount addedUp(std::span<const TileCount> tiles) {
  TileCount whole;
  std::string hashes;
  for (const TileCount& tile : tiles) {
    whole.points = sumOfCounts(whole.points, tile.points);
    whole.triangles = sumOfCounts(whole.triangles, tile.triangles);
    if (tile.box && whole.box) whole.box->expand(*tile.box);
    if (tile.box && !whole.box) whole.box = tile.box;
    hashes += tile.sha256;
  }
  whole.sha256 = sha256Hex(hashes);
  return whole;
}

}  // namespace vdbtools::farm
