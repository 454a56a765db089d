// SPDX-License-Identifier: Apache-2.0
/// @file random_waves.h
/// Textures of waves for law tests: bands, and sums that have zeros.
#pragma once

#include "julia/wave_versor.h"
#include "support/float128.h"

namespace law_tests {

inline julia::WaveTexture randomWaves(Random& random) {
  julia::WaveTexture texture;
  const int factors = random.integer(1, 3);
  for (int f = 0; f < factors; ++f) {
    julia::WaveFactor factor{{}, random.integer(1, 4) * (random.integer(0, 3) == 0 ? -1 : 1)};
    const int count = random.integer(0, 1) ? 1 : random.integer(2, 7);
    for (int i = 0; i < count; ++i) {
      const Quaternion<double> along = random.direction();
      factor.waves.push_back({random.direction() * random.between(0.3, 2.5),
                              count == 1 ? Quaternion<double>::one() : random.direction(),
                              count == 1 ? Quaternion<double>{0, along.b, along.c, along.d} : random.direction()});
    }
    texture.factors.push_back(factor);
  }
  if (random.integer(0, 1)) texture.origin = random.inBall() * 0.5;
  return texture;
}

/// The same octave everywhere.
template <class Real>
class SameOctave final : public julia::ScalarField<Real> {
 public:
  explicit SameOctave(double octave) : mOctave(octave) {}
  void sample(std::span<const Real>, std::span<const Real>, std::span<const Real>, std::span<Real> out) const override {
    std::fill(out.begin(), out.end(), static_cast<Real>(mOctave));
  }
  void ranges(std::span<const std::array<double, 3>>, std::span<const double>,
              std::span<julia::ValueRange> out) const override {
    const double octave = static_cast<double>(static_cast<Real>(mOctave));
    std::fill(out.begin(), out.end(), julia::ValueRange{octave, octave});
  }

 private:
  double mOctave;
};

}  // namespace law_tests
