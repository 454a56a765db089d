// SPDX-License-Identifier: Apache-2.0
/// @file wave_tables.h
/// The waves of a texture, as the kernels and devices read them.
#pragma once

#include "julia/wave_versor.h"

#include "kernels/kernels.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace julia {

template <class Real>
struct WaveTables {
  std::vector<kernels::WaveTerm<Real>> waves;
  std::vector<kernels::WaveSpan<Real>> factors;
  Real origin[4];

  explicit WaveTables(const WaveTexture& texture) {
    store(texture.origin, origin);
    for (const WaveFactor& factor : texture.factors) {
      const std::size_t first = waves.size();
      for (const Wave& wave : factor.waves) {
        kernels::WaveTerm<Real>& term = waves.emplace_back();
        store(wave.frequency, term.frequency);
        store(wave.cosine, term.cosine);
        store(wave.sine, term.sine);
      }
      factors.push_back({first, waves.size(), static_cast<std::uint32_t>(std::abs(factor.power)),
                         static_cast<Real>(factor.power < 0 ? -1 : 1)});
    }
  }

 private:
  static void store(const Quaternion<double>& q, Real (&to)[4]) {
    const Quaternion<Real> rounded = q.as<Real>();
    to[0] = rounded.a;
    to[1] = rounded.b;
    to[2] = rounded.c;
    to[3] = rounded.d;
  }
};

}  // namespace julia
