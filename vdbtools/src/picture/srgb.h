// SPDX-License-Identifier: Apache-2.0
/// @file srgb.h
/// The transfer function of sRGB.
#pragma once

#include <cmath>

namespace vdbtools {

/// Of values from 0 to 1.
template <class Real>
Real linearFromSrgb(Real encoded) {
  return encoded <= Real(0.04045) ? encoded / Real(12.92) : std::pow((encoded + Real(0.055)) / Real(1.055), Real(2.4));
}

}  // namespace vdbtools
