// SPDX-License-Identifier: Apache-2.0
/// @file leaf_signs.h
/// Which nodes of a leaf, and of the first layers of its neighbours on the positive sides, are inside: as bits, so that
/// the few places where the sign changes are found without visiting the others.
#pragma once

#include "vdbtools/base/grids.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdbtools {

inline bool isInside(float field) { return field < 0; }

/// Bit 8 y + z of word x: whether that node of a leaf is inside. Each leaf is read only once, not again for each
/// neighbour.
using InsideBits = std::array<std::uint64_t, 8>;

inline InsideBits insideBits(const openvdb::FloatTree::LeafNodeType& leaf) {
  const float* const values = leaf.buffer().data();
  InsideBits bits{};
  for (std::size_t x = 0; x < 8; ++x) {
    std::array<std::uint8_t, 64> inside;
    for (std::size_t k = 0; k < 64; ++k) inside[k] = isInside(values[64 * x + k]) ? 1 : 0;
    for (std::size_t y = 0; y < 8; ++y) {
      std::uint64_t row = 0;
      for (std::size_t z = 0; z < 8; ++z) row |= std::uint64_t{inside[8 * y + z]} << (8 * z);
      // Byte z becomes bit z of the product's highest byte.
      bits[x] |= (row * 0x0102040810204080) >> 56 << (8 * y);
    }
  }
  return bits;
}

class LeafSigns {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;
  static constexpr unsigned kSide = Leaf::DIM;

  /// A leaf and its seven neighbours on the positive sides: [1] in x, [2] in y, [4] in z, and their sums. If a
  /// neighbour is absent, the field does not change sign between it and the leaves next to it.
  using Neighbours = std::array<const InsideBits*, 8>;

  explicit LeafSigns(const Neighbours& leaves) {
    for (unsigned neighbour = 0; neighbour < 8; ++neighbour) {
      const unsigned dx = neighbour & 1, dy = neighbour >> 1 & 1, dz = neighbour >> 2 & 1;
      const InsideBits* from = leaves[neighbour];
      // Take the whole leaf, or the layer of the neighbour that touches it.
      const unsigned endX = dx ? 1 : kSide, endY = dy ? 1 : kSide, bitsZ = dz ? 1 : 0xff;
      for (unsigned x = 0; x < endX; ++x)
        for (unsigned y = 0; y < endY; ++y) {
          std::uint16_t& bits = mRows[x + dx * kSide][y + dy * kSide];
          if (from) {
            const auto inside = static_cast<unsigned>((*from)[x] >> (y * kSide)) & bitsZ;
            bits |= static_cast<std::uint16_t>(inside << (dz * kSide));
            continue;
          }
          // Assume the sign of the previous node, which comes from a neighbour handled earlier.
          const unsigned before = dz ? unsigned{bits} << 1 : dy ? row(x + dx * kSide, kSide - 1) : row(kSide - 1, y);
          bits |= static_cast<std::uint16_t>(before & (dz ? 1u << kSide : (1u << kSide) - 1));
        }
    }
  }

  /// Bit z: whether node (x, y, z) is inside; x, y, z from 0 to 8.
  unsigned row(unsigned x, unsigned y) const { return mRows[x][y]; }

  /// Bit z: whether the edge along @a axis that begins at (x, y, z) changes sign; x, y, z from 0 to 7.
  unsigned crossings(unsigned x, unsigned y, int axis) const {
    const unsigned here = row(x, y);
    const unsigned there = axis == 0 ? row(x + 1, y) : axis == 1 ? row(x, y + 1) : here >> 1;
    return (here ^ there) & 0xff;
  }

  /// Bit z: whether the corners of the cell that begins at (x, y, z) differ.
  unsigned mixedCells(unsigned x, unsigned y) const {
    const unsigned a = row(x, y), b = row(x + 1, y), c = row(x, y + 1), d = row(x + 1, y + 1);
    const unsigned any = a | b | c | d, all = a & b & c & d;
    return ((any | any >> 1) & ~(all & all >> 1)) & 0xff;
  }

  /// The corners of a cell that are inside: bit 1 for x, 2 for y, 4 for z.
  unsigned cell(unsigned x, unsigned y, unsigned z) const {
    unsigned inside = 0;
    for (unsigned corner = 0; corner < 8; ++corner)
      inside |= (row(x + (corner & 1), y + (corner >> 1 & 1)) >> (z + (corner >> 2)) & 1) << corner;
    return inside;
  }

 private:
  std::array<std::array<std::uint16_t, kSide + 1>, kSide + 1> mRows{};
};

}  // namespace vdbtools
