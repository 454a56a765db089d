// SPDX-License-Identifier: Apache-2.0
/// @file turn_matrix.h
/// The turn from one axis convention to another, as grids take it.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/units.h"

#include <memory>

namespace vdbtools {

/// The quarter turn as a matrix by which OpenVDB multiplies row vectors: its rows are the images of the axes.
inline openvdb::Mat4d turnMatrix(const UpTurn& turn) {
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Vec3d unit(0);
    unit[axis] = 1;
    const openvdb::Vec3d to = turn(unit);
    for (int k = 0; k < 3; ++k) matrix(axis, k) = to[k];
  }
  return matrix;
}

/// Turns the transform of a grid and, if its values are vectors of the world, a copy of these.
inline void turnGrid(openvdb::GridBase& grid, const UpTurn& turn) {
  if (!turn.turns()) return;
  grid.transform().postMult(turnMatrix(turn));
  auto* const vectors = dynamic_cast<openvdb::Vec3SGrid*>(&grid);
  if (!vectors || grid.getVectorType() != openvdb::VEC_CONTRAVARIANT_RELATIVE) return;
  vectors->setTree(std::make_shared<openvdb::Vec3STree>(vectors->tree()));
  for (auto value = vectors->beginValueOn(); value; ++value) value.setValue(turn(*value));
}

}  // namespace vdbtools
