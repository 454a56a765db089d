// SPDX-License-Identifier: Apache-2.0
/// @file tile_file.h
/// The mesh of a tile, DIR/tiles/0007.tile: by layers of blocks in x, as the mesh of the whole is written, so that
/// tiles can be merged while they are read. Numbers are little-endian.
///
///   "JVDBTILE", version (u32), bytes of a coordinate (u16, 4 or 8), whether there are parts (u16, 0 or 1),
///   counts of points, guests, triangles, layers (u64)
///   each layer:  x (i32), number of blocks (u32)
///     each block:  y, z (i32), numbers of points and of triangles (u32)
///     each point:  its edge (u16)
///     each point:  position (3 f32 or f64), normal (3 f32)
///     each triangle:  its cell, and the edges of its three corners (4 u16)
///     each point, then each triangle, if there are parts:  the part of an island that it belongs to (u32)
///
/// An edge is 3 n + axis, where n is the node's offset in its block, and kGuest where another tile owns the point. A
/// corner is the edge, and 2048 for each of 1 (x), 2 (y), 4 (z) by which its block is ahead. A cell is the offset of
/// its first node. Where there are parts (tile_islands.h) the mesh is closed by caps, and kOnCap marks the edges and
/// the cells of what the mesh without caps does not have.
#pragma once

#include "vdbtools/base/grids.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <ostream>
#include <vector>

namespace vdbtools::farm {

inline constexpr std::uint16_t kGuest = 0x8000;  ///< of a point
inline constexpr std::uint16_t kOnCap = 0x4000;  ///< of a point, and of a triangle's cell
inline constexpr unsigned kEdgeBits = 11;        ///< of a corner; the number of the block stands above them
inline constexpr std::uint16_t kEdgeMask = (1u << kEdgeBits) - 1;

/// What a tile has of one layer of blocks.
struct TileLayer {
  struct Block {
    std::int32_t y = 0, z = 0;  ///< of its first node
    std::uint32_t points = 0, triangles = 0;
  };
  using Triangle = std::array<std::uint16_t, 4>;  ///< the cell and the corners

  std::int32_t x = 0;                     ///< of the blocks' first nodes
  std::vector<Block> blocks;              ///< by y, then z
  std::vector<std::uint16_t> edges;       ///< of the points, ascending in each block but for kGuest
  std::vector<openvdb::Vec3d> positions;  ///< world units
  std::vector<openvdb::Vec3s> normals;
  std::vector<Triangle> triangles;  ///< in each block by cells, ascending
  /// The parts of islands that points and triangles belong to; empty unless islands are to be dropped.
  std::vector<std::uint32_t> pointParts, triangleParts;
};

/// Which points and triangles of a tile are wanted.
struct TileFilter {
  std::vector<bool> kept;  ///< of each part of an island
  bool caps = false;       ///< whether those on caps are
};

struct TileCounts {
  std::uint64_t points = 0;  ///< that the tile owns
  std::uint64_t guests = 0;  ///< that its triangles use besides
  std::uint64_t triangles = 0;
  std::uint64_t layers = 0;
};

/// @param layers  by x
/// @return what was written
TileCounts writeTile(std::ostream& stream, const std::vector<TileLayer>& layers, bool doubles);

/// Leaves out what a filter does not want; the marks kOnCap and the parts go.
/// @return false, and nothing is changed, if a part is not among those of the filter
bool applyFilter(const TileFilter& filter, TileLayer& layer);

/// Reads a tile layer by layer. The file is open from the first layer that is read to the last.
class TileReader {
 public:
  /// @throw MissingInputError, DataError  no such file, or no tile
  explicit TileReader(const std::filesystem::path& path);

  /// Of the whole tile, whatever the filter leaves.
  const TileCounts& counts() const { return mCounts; }
  /// Of the layers to come, only what the filter wants is read.
  /// @throw DataError  the tile has no parts
  void setFilter(TileFilter filter);
  /// The x of the layer that next() will read; none at the end.
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
