// SPDX-License-Identifier: Apache-2.0
/// @file limits.h
/// Short names of the numbers that are not finite.
#pragma once

#include <limits>

namespace test_limits {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kFloatNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace test_limits
