// SPDX-License-Identifier: Apache-2.0
/// @file students_t.h
/// Student's t: the half width of a confidence interval in standard errors. It is implemented here because libraries
/// call the C library's logarithms and powers, whose last bits differ.
#pragma once

#include "base/elementary.h"

#include <cmath>
#include <numbers>

namespace vdbtools {

/// The probability that |t| is at most sqrt(degrees) tan(angle) [M. Abramowitz and I. A. Stegun, Handbook of
/// Mathematical Functions, 26.7.3 and 26.7.4].
inline double studentsShare(int degrees, double angle) {
  const double sine = elementary::sin(angle), cosine = elementary::cos(angle);
  const bool isOdd = degrees % 2 != 0;
  double term = isOdd ? cosine : 1, sum = 0;
  for (int k = isOdd ? 2 : 1; k < degrees; k += 2) {
    sum += term;
    term *= cosine * cosine * k / (k + 1);
  }
  return isOdd ? (angle + sine * sum) / (std::numbers::pi / 2) : sine * sum;
}

/// The t that |t| exceeds with a probability of 5 %. @param degrees  of freedom, 1 or more
inline double studentsT95(int degrees) {
  constexpr double kShare = 0.95;
  double low = 0, high = std::numbers::pi / 2;
  for (;;) {
    const double middle = (low + high) / 2;
    if (!(low < middle && middle < high)) break;
    (studentsShare(degrees, middle) < kShare ? low : high) = middle;
  }
  return std::sqrt(static_cast<double>(degrees)) * elementary::tan(high);
}

}  // namespace vdbtools
