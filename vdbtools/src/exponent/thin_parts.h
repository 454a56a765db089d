// SPDX-License-Identifier: Apache-2.0
/// @file thin_parts.h
/// Parts of a target that are so thin that they contain no node of a lattice.
#pragma once

namespace vdbtools {

/// Whether a node lies outside, and so near the surface of a part that contains none that the surface crosses one of
/// the node's cells.
/// @param distance  (x, y, z): from the surface, voxels, negative inside, of the neighbour at this offset
template <class Distance>
bool isBesideThinPart(const Distance& distance) {
  constexpr float kNear = 0.87f;  // half a cell's diagonal
  const float here = distance(0, 0, 0);
  if (here < 0 || here > kNear) return false;
  for (int i = 0; i < 27; ++i)
    if (distance(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1) < 0) return false;
  return true;
}

}  // namespace vdbtools
