// SPDX-License-Identifier: Apache-2.0
/// @file srgb.h
/// The transfer function of sRGB (IEC 61966-2-1), for values from 0 to 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbtools {

template <class Real>
Real linearFromSrgb(Real encoded) {
  return encoded <= Real(0.04045) ? encoded / Real(12.92) : std::pow((encoded + Real(0.055)) / Real(1.055), Real(2.4));
}

template <class Real>
Real srgbFromLinear(Real linear) {
  return linear <= Real(0.0031308) ? Real(12.92) * linear : Real(1.055) * std::pow(linear, 1 / Real(2.4)) - Real(0.055);
}

/// The 8-bit code of a linear value. Values out of range are clamped; values that are not finite become 0.
inline std::uint8_t srgbCode(float linear) {
  const float value = std::isfinite(linear) ? std::clamp(linear, 0.0F, 1.0F) : 0.0F;
  return static_cast<std::uint8_t>(std::lround(255 * srgbFromLinear(value)));
}

}  // namespace vdbtools
