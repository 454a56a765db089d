// SPDX-License-Identifier: Apache-2.0
// Versors of fields and functions, in layers, moved and with symmetries: their definitions, and their bounds over
// balls.
#include "julia/function_versor.h"
#include "julia/mixed_versor.h"
#include "julia/moved_versor.h"
#include "julia/rational_versor.h"
#include "julia/vector_versor.h"
#include "julia/wave_versor.h"
#include "support/float128.h"
#include "support/limits.h"
#include "support/random_grain.h"
#include "support/random_waves.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::Ball;
using julia::Cone;
using julia::DropAxis;
using julia::Quaternion;
using julia::QuaternionBatch;
using julia::Symmetry;
using julia::VersorField;
using law_tests::Random;
using law_tests::Wide;
using test_limits::kInfinity;

template <class Real>
using VersorPointer = std::shared_ptr<const VersorField<Real>>;

constexpr DropAxis kDropped[] = {DropAxis::I, DropAxis::J, DropAxis::K};

/// a . x + b, with its bounds.
template <class Real>
class LinearField final : public julia::ScalarField<Real> {
 public:
  LinearField(const std::array<double, 3>& slope, double offset) : mSlope(slope), mOffset(offset) {}
  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = static_cast<Real>(mSlope[0]) * x[i] + static_cast<Real>(mSlope[1]) * y[i] +
               static_cast<Real>(mSlope[2]) * z[i] + static_cast<Real>(mOffset);
  }
  void ranges(std::span<const std::array<double, 3>> centres, std::span<const double> radii,
              std::span<julia::ValueRange> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) {
      double value = mOffset, size = std::abs(mOffset), square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        value += mSlope[axis] * centres[i][axis];
        size += std::abs(mSlope[axis]) * (std::abs(centres[i][axis]) + radii[i]);
        square += mSlope[axis] * mSlope[axis];
      }
      const double off = std::sqrt(square) * radii[i] + 16 * law_tests::kEpsilon<Real> * size;
      out[i] = {value - off, value + off};
    }
  }

 private:
  std::array<double, 3> mSlope;
  double mOffset;
};

template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> randomField(Random& random, double slope, double low, double high) {
  return std::make_shared<LinearField<Real>>(
      std::array<double, 3>{random.between(-slope, slope), random.between(-slope, slope),
                            random.between(-slope, slope)},
      random.between(low, high));
}

template <class Real>
VersorPointer<Real> randomWaveVersor(Random& random, DropAxis dropped) {
  return std::make_shared<julia::WaveVersor<Real>>(
      law_tests::randomWaves(random), std::make_shared<law_tests::SameOctave<Real>>(random.between(-2, 1)), dropped);
}

template <class Real>
VersorPointer<Real> randomVectorVersor(Random& random, DropAxis dropped) {
  std::vector<std::shared_ptr<const julia::ScalarField<Real>>> components(random.integer(0, 1) ? 3 : 4);
  for (auto& component : components) component = randomField<Real>(random, 1, -1, 1);
  return std::make_shared<julia::VectorVersor<Real>>(components, dropped);
}

template <class Real>
VersorPointer<Real> randomRootVersor(Random& random) {
  julia::Rational rational;
  for (int i = random.integer(1, 4); i > 0; --i)
    rational.top.roots.push_back({random.inBall(), static_cast<double>(random.integer(1, 3))});
  return std::make_shared<julia::RationalVersor<Real>>(rational);
}

template <class Real>
VersorPointer<Real> randomVersor(Random& random, DropAxis dropped) {
  const int kind = random.integer(0, 3);
  if (kind == 3) return law_tests::randomGrainVersor<Real>(random, dropped);
  if (kind == 0) return randomWaveVersor<Real>(random, dropped);
  return kind == 1 ? randomVectorVersor<Real>(random, dropped) : randomRootVersor<Real>(random);
}

Symmetry randomSymmetry(Random& random) {
  Symmetry symmetry{.axis = random.integer(0, 2)};
  switch (random.integer(0, 2)) {
    case 0:
      for (bool& mirrored : symmetry.mirrored) mirrored = random.integer(0, 1) == 1;
      break;
    case 1: symmetry.kaleidoscope = true; [[fallthrough]];
    default: symmetry.fold = random.integer(2, 7);
  }
  for (double& x : symmetry.centre) x = random.between(-0.2, 0.2);
  return symmetry;
}

template <class Real>
Quaternion<Real> at(const VersorField<Real>& field, const Quaternion<Real>& q) {
  QuaternionBatch<Real> points, u;
  points.resize(1);
  points.set(0, q);
  field.versor(points, u);
  return u.get(0);
}

double apart(const auto& p, const auto& q) { return static_cast<double>(law_tests::distance(p, q)); }

template <class Real>
class VersorKinds : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(VersorKinds, Reals);

/// @return how many balls had a cone
template <class Real>
int expectConesHold(const VersorField<Real>& field, Random& random, const std::string& what) {
  std::vector<Ball> balls(60);
  for (Ball& ball : balls) ball = {random.inBall() * 1.5, 0.3 * std::exp2(-random.between(0, 14)), 0};
  std::vector<Cone> cones(balls.size());
  field.cones(balls, cones);
  int known = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (!(cones[i].quadrants < 1)) continue;
    ++known;
    for (int k = 0; k < 20; ++k) {
      // Points on the border as well.
      const Quaternion<double> off = k % 2 ? random.direction() * balls[i].radius : random.inBall() * balls[i].radius;
      const Quaternion<Real> u = at(field, (balls[i].centre + off).template as<Real>());
      // |u - axis| = 2 sin of half the angle.
      const double angle = 2 * std::asin(std::min(1., apart(u, cones[i].axis) / 2));
      EXPECT_LE(angle, cones[i].quadrants * 1.5707963267948966 + 4 * law_tests::kEpsilon<Real>)
          << what << ", ball " << law_tests::text(balls[i].centre) << " of radius " << balls[i].radius;
    }
  }
  return known;
}

// Promise of design.md#211-texture-that-follows-the-thickness: Formulas, fields, layers and symmetries: bounds hold,
//   and their bytes are the same in all ways and from their recipes
TYPED_TEST(VersorKinds, theirConesHoldTheirVersors) {
  using Real = TypeParam;
  Random random(71);
  std::array<int, 5> known{};
  constexpr int kRounds = 60;
  for (int round = 0; round < kRounds; ++round) {
    const DropAxis dropped = kDropped[round % 3];
    const std::string name = " " + std::to_string(round);
    known[0] += expectConesHold(*randomVectorVersor<Real>(random, dropped), random, "vectors" + name);
    const julia::MixedVersor<Real> mixed(randomVersor<Real>(random, dropped), randomVersor<Real>(random, dropped),
                                         randomField<Real>(random, 0.5, -0.3, 1.3), dropped);
    known[1] += expectConesHold(mixed, random, "layers" + name);
    const julia::MovedVersor<Real> moved(randomVersor<Real>(random, dropped),
                                         random.between(0.3, 2) * (random.integer(0, 1) ? 1 : -1),
                                         random.inBall() * 0.5);
    known[2] += expectConesHold(moved, random, "moved" + name);
    const julia::SymmetricVersor<Real> symmetric(randomVersor<Real>(random, dropped), randomSymmetry(random), dropped);
    known[3] += expectConesHold(symmetric, random, "symmetric" + name);
    known[4] += expectConesHold(*law_tests::randomGrainVersor<Real>(random, dropped), random, "grain" + name);
  }
  for (const int each : known) EXPECT_GT(each, kRounds * 60 / 4);
}

// Promise: Layers: "0 is the first alone, 1 ..."
TYPED_TEST(VersorKinds, layersOf0And1AreTheLayersToTheBit) {
  using Real = TypeParam;
  Random random(72);
  const VersorPointer<Real> under = randomWaveVersor<Real>(random, DropAxis::K), over = randomRootVersor<Real>(random);
  for (int i = 0; i < 300; ++i) {
    // Of the plane x = 0.5 the mix is 0 on one side, and of x = 0.6 it is 1 on the other.
    const julia::MixedVersor<Real> mixed(
        under, over, std::make_shared<LinearField<Real>>(std::array<double, 3>{10, 0, 0}, -5), DropAxis::K);
    const Quaternion<Real> q = random.inBall().template as<Real>();
    const Quaternion<Real> u = at(*under, q), v = at(*over, q), mix = at<Real>(mixed, q);
    const Wide m = Wide(10) * Wide(q.a) - 5;
    if (m < -0.001) {
      EXPECT_EQ(mix, u);
    } else if (m > 1.001) {
      EXPECT_EQ(mix, v);
    } else if (m > 0.001 && m < 0.999) {
      const Quaternion<Wide> sum = u.template as<Wide>() * (1 - m) + v.template as<Wide>() * m;
      const Wide length = law_tests::length(sum);
      if (!(length > 0.1)) continue;
      EXPECT_LT(apart(mix, sum * (1 / length)), 400 * law_tests::kEpsilon<Real>) << law_tests::text(q);
    }
  }
}

/// The point that a symmetry takes @a imaged to: after @a turns of its sectors, and mirrored.
Quaternion<double> image(const Symmetry& symmetry, DropAxis dropped, const Quaternion<double>& imaged, int turns,
                         bool mirrored) {
  const julia::Embedding embedding{0, dropped};
  julia::Point x = embedding.point(imaged);
  const auto first = static_cast<std::size_t>(symmetry.axis + 1) % 3, second = (first + 1) % 3;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (symmetry.mirrored[axis] && mirrored) x[axis] = 2 * symmetry.centre[axis] - x[axis];
  double a = x[first] - symmetry.centre[first], b = x[second] - symmetry.centre[second];
  if (symmetry.kaleidoscope && mirrored) b = -b;
  const double angle = 6.283185307179586 * turns / symmetry.fold;
  x[first] = symmetry.centre[first] + a * std::cos(angle) - b * std::sin(angle);
  x[second] = symmetry.centre[second] + a * std::sin(angle) + b * std::cos(angle);
  return embedding.put(imaged, x);
}

// Promise of textures.md: "A set over a target that has the symmetry has it too"
TYPED_TEST(VersorKinds, symmetricOnesAreTheSameAtAllImages) {
  using Real = TypeParam;
  Random random(73);
  int compared = 0;
  for (int round = 0; round < 100; ++round) {
    const DropAxis dropped = kDropped[round % 3];
    const Symmetry symmetry = randomSymmetry(random);
    const julia::SymmetricVersor<Real> field(randomWaveVersor<Real>(random, dropped), symmetry, dropped);
    for (int i = 0; i < 20; ++i) {
      const Quaternion<double> q = random.inBall().template as<Real>().template as<double>();
      // Where it turns slowly, so that the rounding of the images does not show.
      const Ball ball{q, 1e-3, 0};
      Cone cone;
      field.cones({&ball, 1}, {&cone, 1});
      if (!(cone.quadrants < 0.5)) continue;
      ++compared;
      for (int turns = 0; turns < symmetry.fold; ++turns)
        for (const bool mirrored : {false, true})
          EXPECT_LT(apart(at<Real>(field, q.as<Real>()),
                          at<Real>(field, image(symmetry, dropped, q, turns, mirrored).as<Real>())),
                    2e4 * law_tests::kEpsilon<Real>)
              << law_tests::text(q) << ", " << turns << " turns";
    }
  }
  EXPECT_GT(compared, 300);
}

// Promise: "A set over a target that has the symmetry has it too"
TYPED_TEST(VersorKinds, mirrorsAskOnOneSideAlone) {
  using Real = TypeParam;
  Random random(74);
  const VersorPointer<Real> waves = randomWaveVersor<Real>(random, DropAxis::K);
  const julia::SymmetricVersor<Real> field(waves, {.mirrored = {true, false, true}}, DropAxis::K);
  for (int i = 0; i < 100; ++i) {
    const Quaternion<Real> q = random.inBall().template as<Real>();
    EXPECT_EQ(at<Real>(field, q), at(*waves, {std::abs(q.a), q.b, std::abs(q.c), q.d}));
  }
}

TYPED_TEST(VersorKinds, movedOnesAreAskedElsewhere) {
  using Real = TypeParam;
  Random random(75);
  const VersorPointer<Real> waves = randomWaveVersor<Real>(random, DropAxis::K);
  const julia::MovedVersor<Real> field(waves, 2, {0.5, 0.25, 0, 0});
  for (int i = 0; i < 100; ++i) {
    const Quaternion<Real> q = random.inBall().template as<Real>();
    EXPECT_EQ(at<Real>(field, q), at(*waves, {(q.a - Real(0.5)) / 2, (q.b - Real(0.25)) / 2, q.c / 2, q.d / 2}));
  }
}

// Promise: A versor that is a formula ...
TYPED_TEST(VersorKinds, vectorsLieWhereTheyAreRead) {
  using Real = TypeParam;
  Random random(76);
  const auto constant = [](double value) {
    return std::make_shared<LinearField<Real>>(std::array<double, 3>{0, 0, 0}, value);
  };
  for (const DropAxis dropped : kDropped) {
    const julia::VectorVersor<Real> vectors({constant(2), constant(3), constant(6)}, dropped);
    const Quaternion<Real> u = at<Real>(vectors, Quaternion<Real>{1, 2, 3, 4});
    const std::array<Real, 3> x = julia::Embedding{0, dropped}.point(u);
    const std::array<double, 3> wanted = {2. / 7, 3. / 7, 6. / 7};
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(static_cast<double>(x[axis]), wanted[axis], 4 * law_tests::kEpsilon<Real>);
    EXPECT_EQ((julia::Embedding{0, dropped}.slicePart(u)), Real(0));
  }
  const julia::VectorVersor<Real> quaternions({constant(1), constant(-1), constant(1), constant(-1)}, DropAxis::J);
  const Quaternion<Real> u = at<Real>(quaternions, {});
  EXPECT_LT(apart(u, (Quaternion<double>{0.5, -0.5, 0.5, -0.5})), 4 * law_tests::kEpsilon<Real>);
}

// Promise: "Where a direction is undefined ..."
TYPED_TEST(VersorKinds, areOfLength1WhateverTheLengthsAre) {
  using Real = TypeParam;
  const Quaternion<double> none[] = {{}, {kInfinity, 0, 0, 0}, {0, std::nan(""), 1, 0}, {0, 0, -kInfinity, 1}};
  for (const Quaternion<double>& q : none) {
    const julia::FunctionVersor<Real> field([&](auto, auto directions) { directions[0] = q; });
    EXPECT_EQ(at<Real>(field, {}), Quaternion<Real>::one()) << law_tests::text(q);
  }
  for (const double size : {1e-300, 1e-40, 1e-5, 1., 1e30, 1e300}) {
    const julia::FunctionVersor<Real> field([&](auto, auto directions) { directions[0] = {0, 3 * size, 0, 4 * size}; });
    EXPECT_LT(apart(at<Real>(field, {}), (Quaternion<double>{0, 0.6, 0, 0.8})), 4 * law_tests::kEpsilon<Real>) << size;
  }
}

TEST(VersorsOfAllKinds, refuseWhatIsNone) {
  Random random(77);
  const VersorPointer<double> waves = randomWaveVersor<double>(random, DropAxis::K);
  EXPECT_THROW(julia::FunctionVersor<double>({}), std::invalid_argument);
  EXPECT_THROW(julia::VectorVersor<double>({}, DropAxis::K), std::invalid_argument);
  for (const double scale : {0., std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(julia::MovedVersor<double>(waves, scale, {}), std::invalid_argument);
  for (const Symmetry& bad :
       {Symmetry{.fold = 0}, Symmetry{.fold = 65}, Symmetry{.axis = 3}, Symmetry{.centre = {0, std::nan(""), 0}}})
    EXPECT_THROW(julia::SymmetricVersor<double>(waves, bad, DropAxis::K), std::invalid_argument);
}

}  // namespace
