// SPDX-License-Identifier: Apache-2.0
/// @file block_layers.h
/// Sets of blocks: the lattice is processed in blocks of 8^3 nodes, the size of a leaf of a VDB tree. One voxel of the
/// mask stands for a block, so that sets of many millions of blocks stay small.
#pragma once

#include "vdbtools/base/grids.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

using BlockSet = openvdb::MaskTree;

inline constexpr int kBlockLog2 = openvdb::FloatTree::LeafNodeType::LOG2DIM;
inline constexpr int kBlock = 1 << kBlockLog2;

/// The memory of a leaf of a FloatTree with its mask.
inline constexpr double kBytesOfFloatLeaf = 2200;

/// The number of nodes in a box, which may exceed an integer.
inline double volumeOf(const openvdb::CoordBBox& box) {
  const openvdb::Vec3d sides = box.dim().asVec3d();
  return box.empty() ? 0 : sides[0] * sides[1] * sides[2];
}

/// Adds the blocks that hold any of these nodes.
void addBlocks(BlockSet& blocks, const openvdb::CoordBBox& nodes);

/// Adds the blocks on a domain's border and just outside of it where nodes of @a window or their neighbours lie.
void addBorderBlocks(BlockSet& blocks, const openvdb::CoordBBox& domain, openvdb::CoordBBox window);

/// Iterates over a set layer by layer in x.
class BlockLayers {
 public:
  /// @param blocks  without active tiles; call voxelizeActiveTiles()
  explicit BlockLayers(const BlockSet& blocks);

  std::uint64_t blockCount() const { return mCount; }

  /// Returns the origins (nodes) of the blocks in the next non-empty layer, ordered by y, then z; empty at the end.
  std::optional<std::vector<openvdb::Coord>> next();

 private:
  std::vector<const BlockSet::LeafNodeType*> mLeaves;  // by x, then y, then z
  std::uint64_t mCount = 0;
  std::size_t mFirst = 0;  // index of the first leaf of the current layer
  int mOffset = 0;         // offset of the layer within these leaves
};

}  // namespace vdbtools
