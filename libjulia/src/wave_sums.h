// SPDX-License-Identifier: Apache-2.0
/// @file wave_sums.h
/// Sums of waves at single points, in doubles, as bounds need them.
#pragma once

#include "julia/wave_versor.h"

#include "kernels/elementary.h"

namespace julia {

/// The versor of @a q; 1 for 0.
inline Quaternion<double> unit(const Quaternion<double>& q) {
  const double length = norm(q);
  return length > 0 ? q * (1 / length) : Quaternion<double>::one();
}

/// @param p  in units in which a frequency is cycles per unit
inline Quaternion<double> sumOfWaves(const WaveFactor& factor, const Quaternion<double>& p) {
  Quaternion<double> sum;
  for (const Wave& wave : factor.waves) {
    double sine = 0, cosine = 1;
    const Quaternion<double>& w = wave.frequency;
    kernels::sineCosine(4 * (w.a * p.a + w.b * p.b + w.c * p.c + w.d * p.d), &sine, &cosine);
    sum = sum + wave.cosine * cosine + wave.sine * sine;
  }
  return sum;
}

}  // namespace julia
