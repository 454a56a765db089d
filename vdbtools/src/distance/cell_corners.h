// SPDX-License-Identifier: Apache-2.0
/// @file cell_corners.h
/// The values at the corners of the cells that begin in a leaf: the leaf's values, and the first layers of its
/// neighbours on the positive sides.
#pragma once

#include "vdbtools/base/grids.h"

#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <cstdint>

namespace vdbtools {

/// Bit z: whether node z of a row along z is active; row 8 x + y.
inline unsigned activeInRow(const openvdb::FloatTree::LeafNodeType& leaf, openvdb::Index row) {
  return leaf.getValueMask().getWord<openvdb::Byte>(row);
}

class CellCorners {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;
  static constexpr unsigned kSide = Leaf::DIM;

  CellCorners(const Leaf& leaf, const openvdb::tree::ValueAccessor<const openvdb::FloatTree>& accessor) {
    for (unsigned neighbour = 0; neighbour < 8; ++neighbour) {
      const unsigned dx = neighbour & 1, dy = neighbour >> 1 & 1, dz = neighbour >> 2 & 1;
      const openvdb::Coord origin = leaf.origin().offsetBy(static_cast<int>(dx * kSide), static_cast<int>(dy * kSide),
                                                           static_cast<int>(dz * kSide));
      const Leaf* from = neighbour == 0 ? &leaf : accessor.probeConstLeaf(origin);
      const float tile = from ? 0 : accessor.getValue(origin);
      const unsigned endX = dx ? 1 : kSide, endY = dy ? 1 : kSide, endZ = dz ? 1 : kSide;
      for (unsigned x = 0; x < endX; ++x)
        for (unsigned y = 0; y < endY; ++y) {
          float* const row = &mValue[x + dx * kSide][y + dy * kSide][dz * kSide];
          if (!from) {
            std::fill_n(row, endZ, tile);
            continue;
          }
          std::copy_n(from->buffer().data() + (x * kSide + y) * kSide, endZ, row);
          const unsigned on = activeInRow(*from, x * kSide + y) & ((1u << endZ) - 1);
          mActive[x + dx * kSide][y + dy * kSide] |= static_cast<std::uint16_t>(on << (dz * kSide));
        }
    }
  }

  /// The values along z, 0 to 8; x and y likewise.
  const float* row(unsigned x, unsigned y) const { return mValue[x][y]; }

  /// Bit z: whether that node of the row is active.
  unsigned active(unsigned x, unsigned y) const { return mActive[x][y]; }

 private:
  float mValue[kSide + 1][kSide + 1][kSide + 1];
  std::uint16_t mActive[kSide + 1][kSide + 1] = {};
};

}  // namespace vdbtools
