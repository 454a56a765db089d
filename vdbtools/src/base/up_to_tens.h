// SPDX-License-Identifier: Apache-2.0
/// @file up_to_tens.h
/// Rounds numbers of voxels that the program chooses or suggests to multiples of ten.
#pragma once

#include <cmath>

namespace vdbtools {

inline constexpr double kTens = 10;

/// The smallest multiple of ten that is not below a number, apart from rounding errors.
inline double upToTens(double number) {
  constexpr double kRounding = 1e-9;
  return kTens * std::ceil(number / kTens * (1 - kRounding));
}

}  // namespace vdbtools
