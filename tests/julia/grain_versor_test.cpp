// SPDX-License-Identifier: Apache-2.0
// Versors that follow a grain: their definition, the border where their phases begin anew, and their fading.
#include "julia/grain_versor.h"
#include "julia/evaluator.h"
#include "julia/shape_modulus.h"
#include "support/block_signs.h"
#include "support/brick_fields.h"
#include "support/float128.h"
#include "support/random_grain.h"
#include "support/same_bits.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::DropAxis;
using julia::GrainVersor;
using julia::Quaternion;
using law_tests::Random;

constexpr double kTurn = 6.28318530717958647693;

double lengthOf(const Quaternion<double>& q) { return std::sqrt(normSquared(q)); }

/// The phases and the distance at a place.
struct Grain {
  double along = 0, across = 0, depth = 0;
  double alongLength = 1, acrossLength = 1;
};

/// The definition, in doubles.
Quaternion<double> defined(const julia::WaveTexture& texture, const Grain& grain) {
  Quaternion<double> u = Quaternion<double>::one();
  for (const julia::WaveFactor& factor : texture.factors) {
    Quaternion<double> g;
    for (const julia::Wave& wave : factor.waves) {
      const double phase =
          wave.frequency.a * grain.along + wave.frequency.b * grain.across + kTurn * wave.frequency.c * grain.depth;
      g = g + wave.cosine * std::cos(phase) + wave.sine * std::sin(phase);
    }
    g = g * (1 / lengthOf(g));
    if (factor.power < 0) g = conjugate(g);
    for (int times = 0; times < std::abs(factor.power); ++times) u = u * g;
  }
  double certain = 1;
  for (const double length : {grain.alongLength, grain.acrossLength}) {
    const double t = std::min(2 * length * length, 1.);
    certain *= t * t * (3 - 2 * t);
  }
  const Quaternion<double> faded = u * certain + Quaternion<double>::one() * (1 - certain);
  return faded * (1 / lengthOf(faded));
}

template <class Real>
Quaternion<double> versorAt(const julia::WaveTexture& texture, const Grain& grain) {
  const std::array<double, julia::kGrainFields> values{
      grain.alongLength * std::cos(grain.along), grain.alongLength * std::sin(grain.along),
      grain.acrossLength * std::cos(grain.across), grain.acrossLength * std::sin(grain.across), grain.depth};
  typename GrainVersor<Real>::Fields fields;
  for (std::size_t k = 0; k < fields.size(); ++k) fields[k] = std::make_shared<law_tests::SameOctave<Real>>(values[k]);
  const GrainVersor<Real> versor(texture, fields, 1, DropAxis::K);
  julia::QuaternionBatch<Real> q, u;
  q.resize(1);
  q.set(0, {});
  versor.versor(q, u);
  return u.get(0).template as<double>();
}

template <class Real>
class GrainVersors : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(GrainVersors, Reals);

// Promise: Waves along a grain "are as long ..."
TYPED_TEST(GrainVersors, areAsDefined) {
  using Real = TypeParam;
  Random random(2201);
  int compared = 0;
  for (int round = 0; round < 2000; ++round) {
    const julia::WaveTexture texture = law_tests::randomGrainWaves(random);
    const Grain grain{random.between(-3.1, 3.1), random.between(-3.1, 3.1), random.between(-0.5, 0.5),
                      random.between(0.3, 1), random.between(0.3, 1)};
    // Where a sum nearly vanishes, its direction magnifies the rounding.
    double least = 1;
    for (const julia::WaveFactor& factor : texture.factors) {
      Quaternion<double> g;
      double size = 0;
      for (const julia::Wave& wave : factor.waves) {
        const double phase =
            wave.frequency.a * grain.along + wave.frequency.b * grain.across + kTurn * wave.frequency.c * grain.depth;
        g = g + wave.cosine * std::cos(phase) + wave.sine * std::sin(phase);
        size += lengthOf(wave.cosine) + lengthOf(wave.sine);
      }
      least = std::min(least, lengthOf(g) / size / std::abs(factor.power));
    }
    if (!(least > 0.02)) continue;
    ++compared;
    const Quaternion<double> expected = defined(texture, grain), found = versorAt<Real>(texture, grain);
    EXPECT_LT(lengthOf(found - expected), 4000 * law_tests::kEpsilon<Real>) << "round " << round;
    EXPECT_NEAR(lengthOf(found), 1, 8 * law_tests::kEpsilon<Real>);
  }
  EXPECT_GT(compared, 1000);
}

/// A phase of pi and one of -pi are the same, and so are the versors on both sides.
// Promise: Waves along a grain "are as long ..."
TYPED_TEST(GrainVersors, haveNoSeamWhereAPhaseBeginsAnew) {
  using Real = TypeParam;
  Random random(2202);
  for (int round = 0; round < 300; ++round) {
    const julia::WaveTexture texture = law_tests::randomGrainWaves(random);
    const double across = random.between(-3, 3), depth = random.between(-0.3, 0.3), off = 1e-6;
    const Quaternion<double> before = versorAt<Real>(texture, {kTurn / 2 - off, across, depth, 1, 1});
    const Quaternion<double> after = versorAt<Real>(texture, {-kTurn / 2 + off, across, depth, 1, 1});
    const Quaternion<double> beside = versorAt<Real>(texture, {kTurn / 2 - 3 * off, across, depth, 1, 1});
    const double apart = lengthOf(before - beside);
    EXPECT_LT(lengthOf(before - after), 4 * apart + 2e4 * law_tests::kEpsilon<Real>) << "round " << round;
  }
}

// Promise: Waves along a grain "are as long ..."
TYPED_TEST(GrainVersors, are1WhereNothingIsCertain) {
  using Real = TypeParam;
  Random random(2203);
  for (int round = 0; round < 50; ++round) {
    const julia::WaveTexture texture = law_tests::randomGrainWaves(random);
    const Quaternion<double> u = versorAt<Real>(texture, {1, 2, 0.1, 0, random.between(0, 1)});
    EXPECT_EQ(u, Quaternion<double>::one());
  }
}

/// Fields on one lattice are read together. Near points share a cell, and far ones do not.
TYPED_TEST(GrainVersors, haveTheBitsOfFieldsThatAreReadOneByOne) {
  using Real = TypeParam;
  Random random(2205);
  for (int round = 0; round < 12; ++round) {
    const auto dropped = static_cast<DropAxis>(round % 3);
    const law_tests::GrainFields<Real> described = law_tests::randomGrainFields<Real>(random);
    law_tests::GrainFields<Real> plain, mixed = described;
    for (std::size_t k = 0; k < plain.size(); ++k)
      plain[k] = std::make_shared<law_tests::UndescribedField<Real>>(described[k]);
    mixed[static_cast<std::size_t>(round) % mixed.size()] = plain[static_cast<std::size_t>(round) % mixed.size()];
    // Another lattice for one of them.
    law_tests::GrainFields<Real> finer = described, plainFiner = plain;
    finer[4] = law_tests::brickFieldOf<Real>(law_tests::lumpy, julia::Interpolation::Trilinear, 0.6, 1. / 40);
    plainFiner[4] = std::make_shared<law_tests::UndescribedField<Real>>(finer[4]);
    const julia::WaveTexture texture = law_tests::randomGrainWaves(random);
    julia::QuaternionBatch<Real> q;
    q.resize(static_cast<std::size_t>(random.integer(1, 700)));
    Quaternion<double> at;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double step = i % 200 < 100 ? 1e-4 : 2;
      if (i % 200 == 0 || step > 1)
        at = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
      at.a += 1e-4;
      q.set(i, at.as<Real>());
    }
    const auto bits = [&](const law_tests::GrainFields<Real>& fields) {
      const GrainVersor<Real> versor(texture, fields, 1, dropped);
      julia::QuaternionBatch<Real> u;
      versor.versor(q, u);
      std::vector<Real> all;
      for (const auto* part : {&u.a, &u.b, &u.c, &u.d}) all.insert(all.end(), part->begin(), part->end());
      return all;
    };
    EXPECT_EQ(law_tests::bitsOf<Real>(bits(described)), law_tests::bitsOf<Real>(bits(plain))) << "round " << round;
    EXPECT_EQ(law_tests::bitsOf<Real>(bits(mixed)), law_tests::bitsOf<Real>(bits(plain))) << "round " << round;
    EXPECT_EQ(law_tests::bitsOf<Real>(bits(finer)), law_tests::bitsOf<Real>(bits(plainFiner))) << "round " << round;
    law_tests::expectSameBits<Real>([&] { return bits(described); });
  }
}

/// What is proved about blocks of nodes is what their evaluation gives.
// Promise: Waves along a grain "are as long ..."
TYPED_TEST(GrainVersors, blocksHaveTheSignsOfTheirNodes) {
  using Real = TypeParam;
  Random random(2206);
  law_tests::BlockCount sum;
  // A block that is proved to be inside is rare: one in some 200.
  constexpr int kRounds = 60, kMostRounds = 1000, kEnoughInside = 1000;
  for (int round = 0; round < kRounds || (sum.inside < kEnoughInside && round < kMostRounds); ++round) {
    const auto dropped = static_cast<DropAxis>(round % 3);
    const double alpha = std::array{20., 60., 200.}[static_cast<std::size_t>(round / 3) % 3];
    const auto exponent =
        law_tests::brickFieldOf<Real>([&](double x, double y, double z) { return alpha * law_tests::lumpy(x, y, z); },
                                      julia::Interpolation::Trilinear, 0.6, 1. / 64);
    const auto versor = law_tests::randomGrainVersor<Real>(random, dropped);
    const julia::OrbitOptions orbit{.maxIterations = random.integer(2, 6), .logTrap = -1.5};
    const auto evaluator = julia::makeFieldEvaluator<Real>(
        std::make_shared<julia::ShapeModulus<Real>>(exponent, versor, dropped), julia::Embedding{0, dropped}, orbit);
    sum += law_tests::expectBlockSigns(*evaluator, random, std::exp(random.between(std::log(1e-5), std::log(3e-3))),
                                       "round " + std::to_string(round));
    if (this->HasFailure()) return;
  }
  EXPECT_GE(sum.inside, kEnoughInside);
  EXPECT_GT(sum.outside, sum.nodes / 50);
}

TEST(GrainVersorErrors, wavesThatDoNotCloseAreRefused) {
  julia::WaveTexture texture;
  texture.factors.push_back({{{{0.5, 1, 0, 0}, Quaternion<double>::one(), {0, 1, 0, 0}}}, 1});
  GrainVersor<double>::Fields fields;
  for (auto& field : fields) field = std::make_shared<law_tests::SameOctave<double>>(0.5);
  try {
    const GrainVersor<double> versor(texture, fields, 1, DropAxis::K);
    FAIL() << "a wave number of 0.5 was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("0.5; it must be whole"), std::string::npos) << error.what();
  }
}

}  // namespace
