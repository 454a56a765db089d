// SPDX-License-Identifier: Apache-2.0
// Versors of waves: beside the definition in 128 bits, and the laws of their octaves.
#include "julia/wave_versor.h"

#include "support/random_waves.h"
#include "support/reference_waves.h"
#include "support/same_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

namespace {

using julia::DropAxis;
using julia::Quaternion;
using julia::QuaternionBatch;
using julia::WaveFactor;
using julia::WaveTexture;
using julia::WaveVersor;
using law_tests::Random;
using law_tests::randomWaves;
using law_tests::SameOctave;
using law_tests::Wide;

/// The versor by its definition. @param smallest  the least length that was divided by
Quaternion<Wide> versorAt(const WaveTexture& texture, const Quaternion<double>& q, double octave, Wide& smallest) {
  const Quaternion<Wide> blend = julia::reference::wavesAt<Wide>(texture, q.as<Wide>(), octave, smallest);
  return blend * Wide(1 / julia::reference::norm(blend));
}

template <class Real>
WaveVersor<Real> atOctave(const WaveTexture& texture, double octave) {
  return {texture, std::make_shared<SameOctave<Real>>(octave), DropAxis::K};
}

template <class Real>
Quaternion<Real> computedVersor(const WaveVersor<Real>& field, const Quaternion<double>& q) {
  QuaternionBatch<Real> points, u;
  points.resize(1);
  points.set(0, q.as<Real>());
  field.versor(points, u);
  return u.get(0);
}

template <class Real>
QuaternionBatch<Real> randomQuaternions(Random& random, std::size_t count) {
  QuaternionBatch<Real> q;
  q.resize(count);
  for (std::size_t i = 0; i < count; ++i) q.set(i, (random.inBall() * 2.0).template as<Real>());
  return q;
}

template <class Real>
class WaveVersors : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(WaveVersors, Reals);

// Promise of design.md: Versors of waves are those of their definition, have no seam between octaves, and "the versor
//   counts as 1" where a sum vanishes; their bounds hold; their bytes are the same in all ways
TYPED_TEST(WaveVersors, areWhatTheDefinitionSays) {
  using Real = TypeParam;
  constexpr double eps = law_tests::kEpsilon<Real>;
  Random random(41);
  int compared = 0;
  for (int round = 0; round < 300; ++round) {
    const WaveTexture texture = randomWaves(random);
    const double octave = static_cast<double>(static_cast<Real>(random.between(-3, 5)));
    const WaveVersor<Real> field = atOctave<Real>(texture, octave);
    for (int i = 0; i < 10; ++i) {
      const Quaternion<double> q = random.inBall().template as<Real>().template as<double>();
      Wide smallest = 1;
      const Quaternion<Wide> wanted = versorAt(texture, q, octave, smallest);
      // About a zero of a sum the direction is as uncertain as the sum is small.
      if (smallest < 0.05) continue;
      ++compared;
      // Angles of up to 2^6 * 2.5 turns, whose rounding is multiplied by powers of up to 3 * 4.
      const double tolerance = eps * 40 * (10 + 2.5 * std::exp2(octave + 1) * 7) / static_cast<double>(smallest);
      EXPECT_LT(static_cast<double>(law_tests::distance(computedVersor(field, q), wanted.template as<double>())),
                12 * tolerance)
          << "octave " << octave << " at " << law_tests::text(q);
    }
  }
  EXPECT_GT(compared, 1500);
}

TYPED_TEST(WaveVersors, oneOctaveMoreIsThePointsDoubled) {
  using Real = TypeParam;
  Random random(42);
  int compared = 0;
  for (int round = 0; round < 100; ++round) {
    WaveTexture texture = randomWaves(random);
    texture.origin = {};
    const double octave = static_cast<double>(static_cast<Real>(random.between(-3, 5) + 0x1p-3));
    const double higher = octave + 1;
    if (static_cast<double>(static_cast<Real>(higher)) != higher) continue;
    const WaveVersor<Real> coarse = atOctave<Real>(texture, octave), fine = atOctave<Real>(texture, higher);
    const Quaternion<double> q = random.inBall();
    const Quaternion<Real> at = q.as<Real>();
    const Quaternion<Real> one = computedVersor(fine, at.template as<double>());
    const Quaternion<Real> two = computedVersor(coarse, (at * Real(2)).template as<double>());
    if (std::floor(higher) - higher == std::floor(octave) - octave) {
      EXPECT_EQ(one, two) << octave;
      ++compared;
    }
  }
  EXPECT_GT(compared, 50);
}

// Promise: Versors of waves are those ...
TYPED_TEST(WaveVersors, haveNoSeamBetweenOctaves) {
  using Real = TypeParam;
  Random random(43);
  for (int round = 0; round < 200; ++round) {
    const WaveTexture texture = randomWaves(random);
    const double k = random.integer(-2, 4);
    const Quaternion<double> q = random.inBall();
    Wide smallest = 1;
    versorAt(texture, q, k, smallest);
    if (smallest < 0.1) continue;
    const Quaternion<Real> below = computedVersor(atOctave<Real>(texture, k - 1e-4), q);
    const Quaternion<Real> above = computedVersor(atOctave<Real>(texture, k), q);
    EXPECT_LT(static_cast<double>(law_tests::distance(below, above.template as<double>())),
              1e-5 + 4000 * law_tests::kEpsilon<Real> / static_cast<double>(smallest));
  }
}

// Promise: Versors of waves are those ...
TYPED_TEST(WaveVersors, areOfUnitLengthAlsoWhereASumVanishes) {
  using Real = TypeParam;
  // cos + cos of opposite amplitudes is 0 everywhere; the second factor is 0 at the origin alone.
  const Quaternion<double> one = Quaternion<double>::one(), i{0, 1, 0, 0}, none{};
  const WaveTexture nowhere{{{{{{1, 0, 0, 0}, one, i}, {{1, 0, 0, 0}, {-1, 0, 0, 0}, {0, -1, 0, 0}}}, 3}}};
  const WaveTexture atOrigin{{{{{{1, 0, 0, 0}, none, one}, {{0, 1, 0, 0}, none, i}}, 2}}};
  for (const WaveTexture& texture : {nowhere, atOrigin})
    for (const double octave : {-40., 0., 0.5, 3.7, 40., 1e9}) {
      const WaveVersor<Real> field = atOctave<Real>(texture, octave);
      for (const Quaternion<double>& q : {Quaternion<double>{}, Quaternion<double>{0.3, -0.2, 0.1, 4}}) {
        const Quaternion<Real> u = computedVersor(field, q);
        EXPECT_NEAR(std::sqrt(static_cast<double>(normSquared(u))), 1, 1e-5) << octave;
      }
    }
}

// Promise: Versors of waves are those ...
TYPED_TEST(WaveVersors, areTheSameOnAllInstructionSetsAndInAllBatches) {
  using Real = TypeParam;
  Random random(44);
  for (int round = 0; round < 20; ++round) {
    const WaveVersor<Real> field = atOctave<Real>(randomWaves(random), random.between(-3, 6));
    const QuaternionBatch<Real> q = randomQuaternions<Real>(random, 300);
    const auto flat = [](const QuaternionBatch<Real>& batch) {
      std::vector<Real> all;
      for (const std::vector<Real>* part : {&batch.a, &batch.b, &batch.c, &batch.d})
        all.insert(all.end(), part->begin(), part->end());
      return all;
    };
    QuaternionBatch<Real> together;
    law_tests::expectSameBits<Real>([&] {
      field.versor(q, together);
      return flat(together);
    });
    for (std::size_t i = 0; i < q.size(); i += 7)
      EXPECT_EQ(computedVersor(field, q.get(i).template as<double>()), together.get(i));
  }
}

TEST(WaveTextures, RefuseWhatIsNone) {
  const auto field = std::make_shared<SameOctave<double>>(0);
  const julia::Wave wave{{1, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}};
  julia::Wave infinite = wave;
  infinite.sine.c = std::numeric_limits<double>::quiet_NaN();
  for (const WaveTexture& bad : {WaveTexture{}, WaveTexture{{WaveFactor{{}, 1}}}, WaveTexture{{WaveFactor{{wave}, 0}}},
                                 WaveTexture{{WaveFactor{{wave}, 65}}}, WaveTexture{{WaveFactor{{infinite}, 1}}}})
    EXPECT_THROW(WaveVersor<double>(bad, field, DropAxis::K), std::invalid_argument);
}

}  // namespace
