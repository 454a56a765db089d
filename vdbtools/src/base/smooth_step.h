// SPDX-License-Identifier: Apache-2.0
/// @file smooth_step.h
/// A smooth transition from one value to another.
#pragma once

#include <algorithm>

namespace vdbtools {

/// 3 t^2 - 2 t^3: rises from 0 to 1 with zero slope at both ends.
/// @param t  from 0 to 1; the result is within the same range, despite rounding
inline double smoothStep(double t) { return std::min(1.0, t * t * (3 - 2 * t)); }

}  // namespace vdbtools
