// SPDX-License-Identifier: Apache-2.0
#include "render/neighbourhood.h"

#include <algorithm>

namespace vdbtools {

using openvdb::Vec3d;

const std::array<Vec3d, kAxes>& neighbourAxes() {
  static const std::array<Vec3d, kAxes> all = [] {
    std::array<Vec3d, kAxes> result;
    // One of each pair of opposite nodes of a 3^3 lattice: those before its centre.
    for (int i = 0; i < static_cast<int>(kAxes); ++i)
      result[static_cast<std::size_t>(i)] = openvdb::Coord(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1).asVec3d().unit();
    return result;
  }();
  return all;
}

const std::array<julia::Point, kNeighbours>& neighbourDirections() {
  static const std::array<julia::Point, kNeighbours> all = [] {
    std::array<julia::Point, kNeighbours> result;
    for (std::size_t k = 0; k < kAxes; ++k) {
      const Vec3d& axis = neighbourAxes()[k];
      result[2 * k] = {axis[0], axis[1], axis[2]};
      result[2 * k + 1] = {-axis[0], -axis[1], -axis[2]};
    }
    return result;
  }();
  return all;
}

double meanIterationsOutside(std::span<const double> field, std::span<const int> iterations) {
  double sum = 0;
  int outside = 0;
  for (std::size_t i = 0; i < kNeighbours; ++i) {
    if (field[i] < 0) continue;
    sum += iterations[i];
    ++outside;
  }
  return sum / std::max(1, outside);
}

}  // namespace vdbtools
