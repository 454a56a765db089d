// SPDX-License-Identifier: Apache-2.0
#include "field/block_layers.h"

#include <algorithm>

namespace vdbtools {

using openvdb::Coord;
using openvdb::CoordBBox;

void addBlocks(BlockSet& blocks, const CoordBBox& nodes) {
  if (nodes.empty()) return;
  blocks.denseFill({nodes.min() >> kBlockLog2, nodes.max() >> kBlockLog2}, true);
}

void addBorderBlocks(BlockSet& blocks, const CoordBBox& domain, CoordBBox window) {
  window.expand(1);
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool far : {false, true}) {
      CoordBBox slab = domain;
      slab.expand(1);
      Coord low = slab.min(), high = slab.max();
      if (far)
        low[axis] = high[axis] - 1;
      else
        high[axis] = low[axis] + 1;
      CoordBBox face(low, high);
      face.intersect(window);
      addBlocks(blocks, face);
    }
  }
}

BlockLayers::BlockLayers(const BlockSet& blocks) {
  mLeaves.reserve(blocks.leafCount());
  blocks.getNodes(mLeaves);
  mCount = blocks.activeVoxelCount();
  std::sort(mLeaves.begin(), mLeaves.end(), [](const auto* a, const auto* b) { return a->origin() < b->origin(); });
}

std::optional<std::vector<Coord>> BlockLayers::next() {
  using Leaf = BlockSet::LeafNodeType;
  constexpr int kSide = Leaf::DIM;
  while (mFirst < mLeaves.size()) {
    const int x = mLeaves[mFirst]->origin()[0];
    std::size_t last = mFirst;
    while (last < mLeaves.size() && mLeaves[last]->origin()[0] == x) ++last;
    while (mOffset < kSide) {
      const openvdb::Index offset = static_cast<openvdb::Index>(mOffset++) * kSide * kSide;
      std::vector<Coord> layer;
      for (std::size_t i = mFirst; i < last; ++i)
        for (openvdb::Index k = offset; k < offset + kSide * kSide; ++k)
          if (mLeaves[i]->isValueOn(k)) layer.push_back(mLeaves[i]->offsetToGlobalCoord(k) << kBlockLog2);
      if (layer.empty()) continue;
      std::sort(layer.begin(), layer.end());
      return layer;
    }
    mFirst = last;
    mOffset = 0;
  }
  return std::nullopt;
}

}  // namespace vdbtools
