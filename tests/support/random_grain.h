// SPDX-License-Identifier: Apache-2.0
/// @file random_grain.h
/// Textures along a grain, and fields of phases, for law tests.
#pragma once

#include "julia/grain_versor.h"
#include "support/brick_fields.h"
#include "support/random_waves.h"

#include <array>
#include <cmath>
#include <memory>

namespace law_tests {

inline julia::WaveTexture randomGrainWaves(Random& random) {
  julia::WaveTexture texture = randomWaves(random);
  texture.origin = {};
  for (julia::WaveFactor& factor : texture.factors)
    for (julia::Wave& wave : factor.waves)
      wave.frequency = {static_cast<double>(random.integer(-4, 4)), static_cast<double>(random.integer(-4, 4)),
                        random.between(-2, 2), 0};
  return texture;
}

template <class Real>
using GrainFields = typename julia::GrainVersor<Real>::Fields;

/// Phases that turn along two random directions, with a vortex of the second along a line, where nothing is certain.
template <class Real>
GrainFields<Real> randomGrainFields(Random& random) {
  std::array<double, 3> along{}, at{};
  for (double& x : along) x = random.between(-6, 6);
  for (double& x : at) x = random.between(-0.3, 0.3);
  const auto phase = [along](double x, double y, double z) { return along[0] * x + along[1] * y + along[2] * z; };
  const auto vortex = [at](double x, double y, double part) {
    const double r = std::hypot(x - at[0], y - at[1]);
    return r > 0 ? std::min(1., 4 * r) * part / r : 0;
  };
  const auto field = [](const SpaceFunction& value) {
    return brickFieldOf<Real>(value, julia::Interpolation::Trilinear, 0.6, 1. / 24);
  };
  return {field([=](double x, double y, double z) { return std::cos(phase(x, y, z)); }),
          field([=](double x, double y, double z) { return std::sin(phase(x, y, z)); }),
          field([=](double x, double y, double) { return vortex(x, y, x - at[0]); }),
          field([=](double x, double y, double) { return vortex(x, y, y - at[1]); }), field(lumpy)};
}

template <class Real>
std::shared_ptr<const julia::GrainVersor<Real>> randomGrainVersor(Random& random, julia::DropAxis dropped) {
  const GrainFields<Real> fields = randomGrainFields<Real>(random);
  return std::make_shared<julia::GrainVersor<Real>>(randomGrainWaves(random), fields, 1, dropped);
}

}  // namespace law_tests
