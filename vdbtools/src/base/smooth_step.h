// SPDX-License-Identifier: Apache-2.0
/// @file smooth_step.h
/// A smooth way from one value to another.
#pragma once

#include <algorithm>

namespace vdbtools {

/// 3 t^2 - 2 t^3: from 0 to 1 without a slope at either end.
/// @param t  from 0 to 1; the result does not leave that range either, not even by a rounding
inline double smoothStep(double t) { return std::min(1.0, t * t * (3 - 2 * t)); }

}  // namespace vdbtools
