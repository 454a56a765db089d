// SPDX-License-Identifier: Apache-2.0
/// @file reference_waves.h
/// Versors of waves (wave_versor.h) computed from their definition, one point at a time; see reference.h.
#pragma once

#include "julia/wave_versor.h"
#include "support/reference.h"

#include <algorithm>
#include <cmath>

namespace julia::reference {

/// g(p).
template <class T>
Quaternion<T> sumOfWaves(const WaveFactor& factor, const Quaternion<T>& p) {
  using std::acos;
  using std::cos;
  using std::sin;
  const T turn = 2 * T(acos(T(-1)));
  Quaternion<T> sum{};
  for (const Wave& wave : factor.waves) {
    const Quaternion<T> w = wave.frequency.as<T>();
    const T phase = turn * T(w.a * p.a + w.b * p.b + w.c * p.c + w.d * p.d);
    sum = sum + wave.cosine.as<T>() * T(cos(phase)) + wave.sine.as<T>() * T(sin(phase));
  }
  return sum;
}

/// B(p). @param least  lowered to the least |g| of the factors if that is less; the versor is ill-defined near |g| = 0
template <class T>
Quaternion<T> waves(const WaveTexture& texture, const Quaternion<T>& p, T& least) {
  Quaternion<T> product = Quaternion<T>::one();
  for (const WaveFactor& factor : texture.factors) {
    Quaternion<T> g = sumOfWaves<T>(factor, p);
    const T length = norm(g);
    least = std::min<T>(least, length);
    g = length == T(0) ? Quaternion<T>::one() : g * T(1 / length);
    if (factor.power < 0) g = conjugate(g);
    for (int i = 0; i < std::abs(factor.power); ++i) product = product * g;
  }
  return product;
}

/// (1 - t) B(2^k q) + t B(2^(k+1) q) about the origin, whose versor is that of the field. @param least  lowered as in
/// waves(), also to the modulus of this sum
template <class T>
Quaternion<T> wavesAt(const WaveTexture& texture, const Quaternion<T>& q, const T& octave, T& least) {
  using std::exp2;
  using std::floor;
  const T k = floor(octave), f = octave - k, t = f * f * (3 - 2 * f);
  const T scale = T(exp2(static_cast<double>(k)));
  const Quaternion<T> from = q - texture.origin.as<T>();
  const Quaternion<T> coarse = waves<T>(texture, from * scale, least);
  const Quaternion<T> fine = waves<T>(texture, from * T(2 * scale), least);
  const Quaternion<T> blend = coarse + (fine - coarse) * t;
  least = std::min<T>(least, norm(blend));
  return blend;
}

}  // namespace julia::reference
