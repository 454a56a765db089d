// SPDX-License-Identifier: Apache-2.0
/// @file affine_columns.h
/// Affine maps of space as numbers.
#pragma once

#include "vdbtools/base/grids.h"

#include <array>

namespace vdbtools {

/// x -> offset + x_0 columns[0] + x_1 columns[1] + x_2 columns[2]
struct AffineColumns {
  openvdb::Vec3d offset;
  std::array<openvdb::Vec3d, 3> columns;
};

/// The columns of an affine map that is given as a function, from four of its values.
template <class Map>
AffineColumns affineColumns(const Map& map) {
  AffineColumns affine{.offset = map(openvdb::Vec3d(0)), .columns = {}};
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Vec3d unit(0);
    unit[axis] = 1;
    affine.columns[static_cast<std::size_t>(axis)] = map(unit) - affine.offset;
  }
  return affine;
}

}  // namespace vdbtools
