// SPDX-License-Identifier: Apache-2.0
/// @file tile_count.h
/// What is kept of a tile if its plan makes a count: DIR/tiles/0007.json. This makes and checks fractals whose
/// triangles no disk would hold.
#pragma once

#include "farm/tile_file.h"

#include <openvdb/math/BBox.h>
#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools::farm {

struct TileCount {
  std::uint64_t points = 0;  ///< points that the tile owns
  std::uint64_t triangles = 0;
  std::optional<openvdb::BBoxd> box{};  ///< of these points, world units; none without a point
  std::string sha256{};                 ///< of the tile file (tile_file.h), with 32-bit coordinates
};

/// Counts a tile while its layers arrive.
class TileCounter {
 public:
  /// Adds the next layer in the order of x.
  void add(const TileLayer& layer);
  TileCount count() const;

 private:
  TileEncoder mTile{false};
  openvdb::BBoxd mBox;
};

nlohmann::ordered_json jsonOf(const TileCount& count);
/// That JSON as the text that parseTileCount() reads.
std::string encodeTileCount(const TileCount& count);
/// @throw DataError  not such a text
TileCount parseTileCount(const std::string& text);

/// The count of the whole: the sums, the box about all, and the SHA-256 of the tiles' hashes in their order.
/// @throw DataError  the sums do not fit into 64 bits
TileCount addedUp(std::span<const TileCount> tiles);

}  // namespace vdbtools::farm
