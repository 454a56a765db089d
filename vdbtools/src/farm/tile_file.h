// SPDX-License-Identifier: Apache-2.0
/// @file tile_file.h
/// The mesh of a tile, DIR/tiles/0007.tile, in layers of blocks in x like the whole mesh, so that tiles can be merged
/// while they are read. Numbers are little-endian.
///
///   "JVDBTILE", version (u32), bytes of a coordinate (u16, 4 or 8), whether there are parts (u16, 0 or 1),
///   counts of points, guests, triangles, layers (u64)
///   each layer:  x (i32), number of blocks (u32)
///     each block:  y, z (i32), numbers of points and of triangles (u32)
///     each point:  its edge (u16)
///     each point:  position (3 f32 or f64), normal (3 f32)
///     each triangle:  its cell, and the edges of its three corners (4 u16)
///   each point, then each triangle, if there are parts:  the part of an island to which it belongs (u32)
///
/// An edge is 3 n + axis, where n is the node's offset in its block; kGuest is added if another tile owns the point. A
/// corner is the edge, plus 2048 times the sum of 1 (x), 2 (y), 4 (z) for each axis along which its block is the next
/// one. A cell is the offset of its first node. If there are parts (tile_islands.h), caps close the mesh, and kOnCap
/// marks the edges and the cells that the mesh without caps does not have.
#pragma once

#include "vdbtools/base/grids.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace vdbtools::farm {

inline constexpr std::uint16_t kGuest = 0x8000;  ///< for a point
inline constexpr std::uint16_t kOnCap = 0x4000;  ///< for a point, and for a triangle's cell
inline constexpr unsigned kEdgeBits = 11;  ///< bits of the edge in a corner; the bits above are the number of the block
inline constexpr std::uint16_t kEdgeMask = (1u << kEdgeBits) - 1;

/// The part of a tile in one layer of blocks.
struct TileLayer {
  struct Block {
    std::int32_t y = 0, z = 0;  ///< of the block's first node
    std::uint32_t points = 0, triangles = 0;
  };
  using Triangle = std::array<std::uint16_t, 4>;  ///< the cell and the corners

  std::int32_t x = 0;                     ///< x of the blocks' first nodes
  std::vector<Block> blocks;              ///< ordered by y, then z
  std::vector<std::uint16_t> edges;       ///< of the points, ascending in each block except for kGuest
  std::vector<openvdb::Vec3d> positions;  ///< world units
  std::vector<openvdb::Vec3s> normals;
  std::vector<Triangle> triangles;  ///< in each block ordered by cells, ascending
  /// The parts of islands to which points and triangles belong; empty unless islands are to be dropped.
  std::vector<std::uint32_t> pointParts, triangleParts;
};

/// Selects points and triangles of a tile.
struct TileFilter {
  std::vector<bool> keptParts;  ///< whether each part of an island is kept
  bool caps = false;            ///< whether points and triangles on caps are kept
};

struct TileCounts {
  std::uint64_t points = 0;  ///< points that the tile owns
  std::uint64_t guests = 0;  ///< further points that its triangles use
  std::uint64_t triangles = 0;
  std::uint64_t layers = 0;
};

/// Makes the file of a tile from its layers. Only their encoded bytes are stored until the end, because the head of the
/// file contains the total counts.
class TileEncoder {
 public:
  /// @param doubles  whether coordinates have 64 bits
  explicit TileEncoder(bool doubles) : mDoubles(doubles) {}

  /// Adds the next layer in the order of x.
  void add(const TileLayer& layer);
  /// Counts of what was added.
  const TileCounts& counts() const { return mCounts; }
  void write(std::ostream& stream) const;

 private:
  bool mDoubles, mParts = false;
  TileCounts mCounts;
  std::vector<std::string> mLayers;
};

/// Removes what a filter does not select, and the marks kOnCap and the parts.
/// @return false, without changes, if a part is unknown to the filter
bool applyFilter(const TileFilter& filter, TileLayer& layer);

/// Reads a tile layer by layer. The file is open from the first layer to the last.
class TileReader {
 public:
  /// @throw MissingInputError, DataError  the file does not exist, or is not a tile
  explicit TileReader(const std::filesystem::path& path);

  /// The counts of the whole tile, regardless of the filter.
  const TileCounts& counts() const { return mCounts; }
  /// Restricts the remaining layers to what the filter selects.
  /// @throw DataError  the tile has no parts
  void setFilter(TileFilter filter);
  /// The x of the layer that next() will read; empty at the end.
  std::optional<std::int32_t> nextX() const { return mNextX; }
  /// @throw DataError  truncated or broken; IoError
  TileLayer next();

 private:
  void readX();
  void read(void* to, std::size_t bytes);
  [[noreturn]] void refuse(const char* why) const;

  std::filesystem::path mPath;
  std::ifstream mStream;
  std::streamoff mPosition = 0;
  std::uint64_t mLeft = 0;  ///< bytes
  bool mDoubles = false, mHasParts = false;
  std::optional<TileFilter> mFilter;
  TileCounts mCounts;
  std::uint64_t mRead = 0;  ///< layers
  std::optional<std::int32_t> mNextX;
};

}  // namespace vdbtools::farm
