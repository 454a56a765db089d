// SPDX-License-Identifier: Apache-2.0
/// @file srgb.h
/// The transfer function of sRGB (IEC 61966-2-1), for values from 0 to 1.
#pragma once

#include "base/elementary.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdbtools {

template <class Real>
Real linearFromSrgb(Real encoded) {
  return encoded <= Real(0.04045)
             ? encoded / Real(12.92)
             : static_cast<Real>(elementary::pow((encoded + Real(0.055)) / Real(1.055), Real(2.4)));
}

template <class Real>
Real srgbFromLinear(Real linear) {
  return linear <= Real(0.0031308)
             ? Real(12.92) * linear
             : Real(1.055) * static_cast<Real>(elementary::pow(linear, 1 / Real(2.4))) - Real(0.055);
}

/// The smallest linear value of each 8-bit code from 1 on.
inline const std::array<float, 255>& leastOfSrgbCodes() {
  static const std::array<float, 255> least = [] {
    std::array<float, 255> values{};
    for (std::size_t code = 1; code <= values.size(); ++code) {
      // Positive floats are ordered like their bits.
      std::uint32_t below = 0, above = std::bit_cast<std::uint32_t>(1.0F);
      while (above - below > 1) {
        const std::uint32_t middle = below + (above - below) / 2;
        const float encoded = srgbFromLinear(std::bit_cast<float>(middle));
        (255 * encoded < static_cast<float>(code) - 0.5F ? below : above) = middle;
      }
      values[code - 1] = std::bit_cast<float>(above);
    }
    return values;
  }();
  return least;
}

/// The 8-bit code of a linear value. Values out of range are clamped; values that are not finite become 0.
inline std::uint8_t srgbCode(float linear) {
  const std::array<float, 255>& least = leastOfSrgbCodes();
  if (!std::isfinite(linear)) return 0;
  return static_cast<std::uint8_t>(std::upper_bound(least.begin(), least.end(), linear) - least.begin());
}

}  // namespace vdbtools
