// SPDX-License-Identifier: Apache-2.0
/// @file voxel_choice.h
/// How fine a lattice is: the size of a voxel, or the number of voxels along the longest side of a shape.
#pragma once

#include <optional>

namespace vdbtools {

struct VoxelChoice {
  std::optional<double> voxelSize{};   ///< world units
  std::optional<double> resolution{};  ///< voxels along the longest side; exactly one of the two is set

  /// The voxel size for a shape, world units.
  /// @throw std::invalid_argument  distances in 32-bit floats cannot represent the size
  /// @throw DataError              likewise, at a resolution that suits any shape of an ordinary size
  double sizeFor(double longestSide) const;

  bool operator==(const VoxelChoice&) const = default;
};

/// The smallest multiple of ten that is not below a number, apart from rounding errors: a number of voxels that the
/// program chooses or suggests.
double upToTens(double number);

}  // namespace vdbtools
