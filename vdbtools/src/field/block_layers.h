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

/// How many nodes a box holds, which may be more than an integer can say.
inline double volumeOf(const openvdb::CoordBBox& box) {
  const openvdb::Vec3d sides = box.dim().asVec3d();
  return box.empty() ? 0 : sides[0] * sides[1] * sides[2];
}

/// Adds the blocks that hold any of these nodes.
void addBlocks(BlockSet& blocks, const openvdb::CoordBBox& nodes);

/// Adds the blocks on a domain's border and just outside of it, as far as nodes of @a window or next to it lie there.
void addBorderBlocks(BlockSet& blocks, const openvdb::CoordBBox& domain, openvdb::CoordBBox window);

/// Goes through a set layer by layer in x.
class BlockLayers {
 public:
  /// @param blocks  without active tiles: voxelizeActiveTiles()
  explicit BlockLayers(const BlockSet& blocks);

  std::uint64_t blockCount() const { return mCount; }

  /// The next layer that holds blocks: the origins of these, nodes, by y, then z. Nothing at the end.
  std::optional<std::vector<openvdb::Coord>> next();

 private:
  std::vector<const BlockSet::LeafNodeType*> mLeaves;  // by x, then y, then z
  std::uint64_t mCount = 0;
  std::size_t mFirst = 0;  // of the leaves that hold the current layer
  int mOffset = 0;         // of the layer within these
};

}  // namespace vdbtools
