// SPDX-License-Identifier: Apache-2.0
/// @file same_bits.h
#pragma once

#include "kernels/elementary.h"

#include <cmath>

namespace julia::device {

/// Whether two numbers are the same, bit for bit; any NaN is as good as any other.
template <class Real>
bool sameBits(Real a, Real b) {
  return kernels::bitsOf(a) == kernels::bitsOf(b) || (std::isnan(a) && std::isnan(b));
}

}  // namespace julia::device
