// SPDX-License-Identifier: Apache-2.0
// What is proved about versors of waves over small balls, and about blocks of nodes by it.
#include "julia/evaluator.h"
#include "julia/shape_modulus.h"
#include "julia/wave_versor.h"
#include "support/block_signs.h"
#include "support/brick_fields.h"
#include "support/float128.h"
#include "support/random_waves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace {

using julia::DropAxis;
using julia::Interpolation;
using julia::Quaternion;
using julia::WaveTexture;
using julia::WaveVersor;
using law_tests::brickFieldOf;
using law_tests::lumpy;
using law_tests::Random;

template <class Real>
class WaveProofs : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(WaveProofs, Reals);

/// The cone of a ball contains the versors of its points. If the ball is so small that they turn by a few hundredths of
/// a radian, the cone is hardly wider than they are apart.
TYPED_TEST(WaveProofs, coneOfASmallBallIsCloseToItsVersors) {
  using Real = TypeParam;
  Random random(1201);
  std::vector<double> ratios;
  for (int round = 0; round < 300; ++round) {
    const WaveTexture texture = law_tests::randomWaves(random);
    const double octave = random.between(-2, 4);
    const WaveVersor<Real> field(texture, std::make_shared<law_tests::SameOctave<Real>>(octave), DropAxis::K);
    double slope = 0;
    for (const julia::WaveFactor& factor : texture.factors)
      for (const julia::Wave& wave : factor.waves)
        slope = std::max(slope, std::abs(factor.power) * 2 * 3.14159265 * std::sqrt(normSquared(wave.frequency)));
    const julia::Ball ball{random.inBall(), 0.02 / (slope * std::exp2(octave))};
    julia::Cone cone;
    field.cones({&ball, 1}, {&cone, 1});
    julia::QuaternionBatch<Real> q, u;
    q.resize(400);
    for (std::size_t i = 0; i < q.size(); ++i)
      q.set(i, (ball.centre + random.direction() * ball.radius).template as<Real>());
    field.versor(q, u);
    double widest = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double chord = std::sqrt(normSquared(u.get(i).template as<double>() - cone.axis));
      widest = std::max(widest, 2 * std::asin(std::min(chord / 2, 1.)));
    }
    const double angle = cone.quadrants * 1.57079632679489661923;
    EXPECT_LE(widest, cone.quadrants < 1 ? angle * (1 + 1e-12) : 4) << "round " << round;
    ratios.push_back(cone.quadrants < 1 ? angle / widest : 1e9);
  }
  std::sort(ratios.begin(), ratios.end());
  this->RecordProperty("median", std::to_string(ratios[ratios.size() / 2]));
  this->RecordProperty("ninth tenth", std::to_string(ratios[ratios.size() * 9 / 10]));
  EXPECT_LT(ratios[ratios.size() / 2], 1.6);
  EXPECT_LT(ratios[ratios.size() * 9 / 10], 2.5);
}

/// On a lattice much finer than the waves, most nodes near the surface are decided in cubes, inside and outside.
TYPED_TEST(WaveProofs, blocksHaveTheSignsOfTheirNodes) {
  using Real = TypeParam;
  Random random(1202);
  law_tests::BlockCount sum;
  for (int round = 0; round < 60; ++round) {
    const double alpha = std::array{20., 60., 200.}[static_cast<std::size_t>(round) % 3];
    const auto field = brickFieldOf<Real>([&](double x, double y, double z) { return alpha * lumpy(x, y, z); },
                                          Interpolation::Trilinear, 0.6, 1. / 64);
    const auto octave = brickFieldOf<Real>([&](double x, double y, double z) { return 1.5 + 4 * lumpy(z, x, y); },
                                           Interpolation::Trilinear, 0.6, 1. / 32);
    const WaveTexture texture = law_tests::randomWaves(random);
    const julia::Embedding embedding{.slice = random.integer(0, 1) ? 0 : random.between(-0.3, 0.3)};
    const julia::OrbitOptions options{.maxIterations = random.integer(2, 6),
                                      .escapeRadius = std::array{2., 20.}[static_cast<std::size_t>(round) % 2],
                                      .logTrap = round % 4 == 0 ? -std::numeric_limits<double>::infinity() : -1.5};
    const auto evaluator = julia::makeFieldEvaluator<Real>(
        std::make_shared<julia::ShapeModulus<Real>>(
            field, std::make_shared<WaveVersor<Real>>(texture, octave, embedding.dropped), embedding.dropped),
        embedding, options);
    sum += law_tests::expectBlockSigns(*evaluator, random, std::exp(random.between(std::log(1e-5), std::log(3e-3))),
                                       "round " + std::to_string(round));
    if (this->HasFailure()) return;
  }
  this->RecordProperty("nodes", sum.nodes);
  this->RecordProperty("inside", sum.inside);
  this->RecordProperty("outside", sum.outside);
  EXPECT_GT(sum.inside, sum.nodes / 200);
  EXPECT_GT(sum.outside, sum.nodes / 50);
}

}  // namespace
