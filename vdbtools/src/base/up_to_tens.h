// SPDX-License-Identifier: Apache-2.0
/// @file up_to_tens.h
/// Numbers of voxels that the program chooses, or names to a user, are multiples of ten.
#pragma once

#include <cmath>

namespace vdbtools {

inline constexpr double kTens = 10;

/// The multiple of ten from a number on, but for its rounding.
inline double upToTens(double number) {
  constexpr double kRounding = 1e-9;
  return kTens * std::ceil(number / kTens * (1 - kRounding));
}

}  // namespace vdbtools
