// SPDX-License-Identifier: Apache-2.0
/// @file wave_sums.h
/// Sums of waves at single points, in doubles, as bounds need them.
#pragma once

#include "julia/wave_versor.h"

#include "kernels/elementary.h"

#include <cmath>
#include <cstdlib>

namespace julia {

inline constexpr double kTurn = 6.28318530717958647693;

/// The versor of @a q; 1 for 0.
inline Quaternion<double> unit(const Quaternion<double>& q) {
  const double length = norm(q);
  return length > 0 ? q * (1 / length) : Quaternion<double>::one();
}

/// |c cos + s sin| is at most this, and so is its derivative by the phase.
inline double amplitudeOf(const Wave& wave) { return std::sqrt(normSquared(wave.cosine) + normSquared(wave.sine)); }

/// Upper bounds of a sum of waves.
struct WaveSumBound {
  double slope = 0;      ///< of its change per unit of space
  double amplitude = 0;  ///< of its length
};

inline WaveSumBound boundOf(const WaveFactor& factor) {
  WaveSumBound bound;
  for (const Wave& wave : factor.waves) {
    const double size = amplitudeOf(wave);
    bound.slope += size * norm(wave.frequency) * kTurn;
    bound.amplitude += size;
  }
  return bound;
}

/// Radians by which a texture's versor typically turns per unit of space, at octave 0.
inline double typicalTurning(const WaveTexture& texture) {
  double squares = 0;
  for (const WaveFactor& factor : texture.factors) {
    const WaveSumBound bound = boundOf(factor);
    const double slope = std::abs(factor.power) * bound.slope / bound.amplitude;
    squares += slope * slope;
  }
  return std::sqrt(squares);
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
