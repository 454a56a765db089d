// SPDX-License-Identifier: Apache-2.0
/// @file tile_islands.h
/// The islands of a tile, DIR/tiles/0007.islands: their parts in the tile, and where they touch other tiles, so that
/// the parts can be joined when the tiles are merged. Islands are defined in vdbtools/field/islands.h.
///
/// A tile labels the inside nodes of its own box and of one layer beyond it on the positive sides, including edges and
/// corners, as far as the domain reaches. Nodes that are connected within these form one part. For any two neighbouring
/// nodes, the tile of the first one contains both, so parts of different tiles are joined wherever they share a node.
/// Numbers in the file are little-endian.
///
///   "JVDBISLE", version, 0 (u32), counts of parts and of the runs of each kind (u64)
///   each part: its own nodes, points, points on caps (u64), box and first node of its own nodes (9 i32), 0 (u32)
///   runs along z: x, y, first z, last z (i32), part (u32); each kind by x, y, z
///     the own nodes on the first layers in x, y and z, which other tiles label as nodes beyond their boxes
///     the nodes beyond the own box
///     all own nodes
#pragma once

#include "field/island_choice.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/surface/extract_mesh.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <ostream>
#include <span>
#include <vector>

namespace vdbtools::farm {

/// A run of inside nodes along z.
struct InsideRun {
  std::int32_t x = 0, y = 0, first = 0, last = 0;
  std::uint32_t part = 0;
};

struct TilePart {
  Island island;             ///< the nodes that the tile owns; there may be none
  std::uint64_t points = 0;  ///< points of the mesh that the tile owns, without those on caps
  std::uint64_t capPoints = 0;
};

/// The parts of islands in a tile.
class TileIslands {
 public:
  /// @param field  covers a window that reaches at least one node beyond the box, unless the domain ends there
  /// @param box    the nodes that the tile owns
  TileIslands(const FractalField& field, const FieldSource& source, const openvdb::CoordBBox& box, Monitor& monitor);

  const std::vector<TilePart>& parts() const { return mParts; }

  /// The part of an inside node; empty for other nodes, and for nodes without a label.
  std::optional<std::uint32_t> partOf(const openvdb::Coord& node) const;
  /// The part of a point on an edge, i.e. the part of the edge's only inside end.
  std::uint32_t partOf(const EdgePlace& edge) const;

  /// Counts a point that the tile owns.
  void countPoint(std::uint32_t part, bool onCap) { ++(onCap ? mParts[part].capPoints : mParts[part].points); }

  void write(std::ostream& stream) const;

 private:
  void findRuns(const FractalField& field, const FieldSource& source, Monitor& monitor);
  void joinRuns(Monitor& monitor);
  std::span<const InsideRun> row(int x, int y) const;
  std::optional<InsideRun> ownPart(const InsideRun& run) const;

  openvdb::CoordBBox mBox, mLabelled;
  std::vector<InsideRun> mRuns;      ///< ordered by x, y, z
  std::vector<std::uint64_t> mRows;  ///< for each (x, y), the number of its first run; finally the total number of runs
  std::vector<TilePart> mParts;
};

/// Reads the islands of a tile.
class TileIslandsReader {
 public:
  /// @throw MissingInputError, DataError  the file does not exist, or does not hold islands
  explicit TileIslandsReader(std::filesystem::path path);

  const std::vector<TilePart>& parts() const { return mParts; }
  const std::vector<InsideRun>& faces() const { return mFaces; }    ///< on the first layers
  const std::vector<InsideRun>& beyond() const { return mBeyond; }  ///< beyond the own box

  /// Passes on all own nodes, piece by piece. @throw IoError
  void forEachOwn(const std::function<void(std::span<const InsideRun>)>& body) const;

 private:
  std::filesystem::path mPath;
  std::vector<TilePart> mParts;
  std::vector<InsideRun> mFaces, mBeyond;
  std::uint64_t mOwn = 0;  ///< number of runs
  std::streamoff mOwnAt = 0;
};

/// The islands of all tiles, joined.
struct JoinedIslands {
  IslandReport report;
  std::vector<std::vector<bool>> keptParts;  ///< for each tile, whether each part is kept
  std::uint64_t points = 0;                  ///< number of points in the remaining mesh, without those on caps
  std::uint64_t capPoints = 0;
};

/// Joins the parts of tiles and chooses the islands to keep, as dropIslands() does.
/// @throw DataError  as dropIslands(); the tiles do not match
JoinedIslands joinIslands(std::span<const TileIslandsReader> tiles, const IslandOptions& options, double voxelSize,
                          Monitor& monitor);

}  // namespace vdbtools::farm
