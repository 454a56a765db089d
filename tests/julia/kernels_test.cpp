// SPDX-License-Identifier: Apache-2.0
// The vector kernels: the same bits from every instruction set, and right ones.
#include "kernels/kernels.h"
#include "support/float128.h"

#include "julia/brick_field.h"
#include "julia/evaluator.h"
#include "julia/instruction_set.h"
#include "julia/quadratic_map.h"
#include "julia/random_roots.h"
#include "julia/rational_map.h"
#include "support/same_bits.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <random>
#include <type_traits>

namespace {

using julia::InstructionSet;
using julia::Quaternion;
using julia::QuaternionBatch;
using julia::Rational;
using law_tests::expectSameBits;
using law_tests::KeepInstructionSet;

Rational seededRational(std::uint64_t seed, int count, double maxPower, bool integer) {
  Rational rational{
      0.25, julia::randomPolynomial({.seed = seed, .count = count, .maxPower = maxPower, .integerPowers = integer}),
      julia::randomPolynomial({.seed = seed + 1, .count = count / 2, .maxPower = 3, .integerPowers = integer})};
  return rational;
}

/// Points in a box, on roots, very near to roots, on the real line through a root, and far away.
template <class Real>
QuaternionBatch<Real> trickyPoints(const Rational& rational, std::size_t count) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-0.7, 0.7);
  std::vector<Quaternion<double>> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back({place(random), place(random), place(random), place(random)});
  for (const julia::Root& root : rational.top.roots) {
    const Quaternion<double> t = root.position;
    points.push_back(t);
    points.push_back({t.a + 0.25, t.b, t.c, t.d});
    points.push_back({t.a - 0.25, t.b, t.c, t.d});
    points.push_back({t.a, t.b + 1e-18, t.c, t.d});
  }
  for (const double scale : {1e-40, 1e-25, 1e-12, 19.0, 1e8}) points.push_back({scale, -scale, scale / 3, 0});
  QuaternionBatch<Real> batch;
  batch.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) batch.set(i, points[i].as<Real>());
  return batch;
}

template <class Real>
std::vector<Real> flattened(const QuaternionBatch<Real>& batch) {
  std::vector<Real> all;
  for (const std::vector<Real>* part : {&batch.a, &batch.b, &batch.c, &batch.d})
    all.insert(all.end(), part->begin(), part->end());
  return all;
}

template <class Real>
class Kernels : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Kernels, Reals);

// Promise: "any size of a batch, and any ..."
TYPED_TEST(Kernels, rationalsAreTheSameOnAllInstructionSets) {
  using Real = TypeParam;
  for (const bool integer : {false, true})
    for (const double maxPower : {11., 50., 300.})
      for (const std::size_t count : {1u, 15u, 127u, 128u, 129u, 700u}) {
        const Rational rational = seededRational(count, 12, maxPower, integer);
        const julia::RationalEvaluator<Real> evaluator(rational);
        const QuaternionBatch<Real> q = trickyPoints<Real>(rational, count);
        expectSameBits<Real>([&] {
          QuaternionBatch<Real> u;
          evaluator.versor(q, u);
          std::vector<Real> l(q.size());
          evaluator.logModulus(q, l);
          std::vector<Real> all = flattened(u);
          all.insert(all.end(), l.begin(), l.end());
          return all;
        });
      }
}

// Promise: "any size of a batch, and any ..."
TYPED_TEST(Kernels, orbitsAreTheSameOnAllInstructionSets) {
  using Real = TypeParam;
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(-1.2, 1.2);
  std::vector<julia::Point> points(1000);
  for (julia::Point& x : points) x = {place(random), place(random), place(random)};
  const std::vector<std::shared_ptr<const julia::Map<Real>>> maps = {
      std::make_shared<julia::RationalMap<Real>>(seededRational(9, 6, 4, false)),
      std::make_shared<julia::QuadraticMap<Real>>(Quaternion<double>{-0.2, 0.6, 0.2, 0.1})};
  for (const auto& map : maps) {
    const auto evaluator = julia::makeFieldEvaluator<Real>(map, {0.1, julia::DropAxis::K}, {.maxIterations = 8});
    expectSameBits<double>([&] {
      std::vector<double> field(points.size());
      evaluator->evaluate(points, field, {});
      return field;
    });
  }
}

// Promise: "any size of a batch, and any ..."
TYPED_TEST(Kernels, aPointDoesNotDependOnItsBatch) {
  using Real = TypeParam;
  const Rational rational = seededRational(3, 9, 11, false);
  const julia::RationalEvaluator<Real> evaluator(rational);
  const QuaternionBatch<Real> q = trickyPoints<Real>(rational, 300);
  QuaternionBatch<Real> together;
  evaluator.versor(q, together);
  for (std::size_t i = 0; i < q.size(); ++i) {
    QuaternionBatch<Real> one, alone;
    one.resize(1);
    one.set(0, q.get(i));
    evaluator.versor(one, alone);
    EXPECT_EQ(alone.get(0), together.get(i)) << i;
  }
}

// The careful path is another text: what both compute is the same quaternion.
TYPED_TEST(Kernels, agreeWithTheCarefulPath) {
  using Real = TypeParam;
  const double eps = std::numeric_limits<Real>::epsilon();
  for (const bool integer : {false, true}) {
    const Rational rational = seededRational(5, 20, 13, integer);
    double powers = 0;
    for (const auto* polynomial : {&rational.top, &rational.bottom}) powers += julia::summedPowers(*polynomial);
    const julia::RationalEvaluator<Real> evaluator(rational);
    const QuaternionBatch<Real> q = trickyPoints<Real>(rational, 500);
    QuaternionBatch<Real> u;
    evaluator.versor(q, u);
    std::vector<Real> l(q.size());
    evaluator.logModulus(q, l);
    for (std::size_t i = 0; i < 500; ++i) {
      const Quaternion<Real> difference = u.get(i) - evaluator.versor(q.get(i));
      EXPECT_LT(std::sqrt(double(normSquared(difference))), 4 * eps * powers) << i;
      EXPECT_NEAR(l[i], evaluator.logModulus(q.get(i)), 4 * eps * powers) << i;
    }
  }
}

/// Bricks of a function of the node, over a few bricks in each direction.
template <class Function>
std::shared_ptr<const julia::Bricks> bricksOfNodes(julia::Interpolation interpolation, const Function& f) {
  auto bricks = std::make_shared<julia::Bricks>();
  bricks->interpolation = interpolation;
  bricks->count = {3, 2, 4};
  const int side = static_cast<int>(bricks->side()), before = static_cast<int>(bricks->before());
  for (int bx = 0; bx < 3; ++bx)
    for (int by = 0; by < 2; ++by)
      for (int bz = 0; bz < 4; ++bz) {
        bricks->brickAt.push_back(static_cast<std::uint32_t>(bricks->brickAt.size()));
        for (int x = 0; x < side; ++x)
          for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z)
              bricks->values.push_back(
                  static_cast<float>(f(bx * 8 + x - before, by * 8 + y - before, bz * 8 + z - before)));
      }
  return bricks;
}

template <class Real>
std::vector<Real> sampled(const julia::BrickField<Real>& field, const std::vector<julia::Point>& points) {
  std::vector<Real> x, y, z, out(points.size());
  for (const julia::Point& p : points) {
    x.push_back(static_cast<Real>(p[0]));
    y.push_back(static_cast<Real>(p[1]));
    z.push_back(static_cast<Real>(p[2]));
  }
  field.sample(x, y, z, out);
  return out;
}

julia::BrickPlacement indexPlacement() {
  julia::BrickPlacement placement;
  for (std::size_t k = 0; k < 3; ++k) placement.matrix[k][k] = 1;
  placement.high = {23, 15, 31};
  return placement;
}

// Both interpolations give back any function that is linear along each axis, between and across bricks.
TYPED_TEST(Kernels, bricksReproduceLinearFunctions) {
  using Real = TypeParam;
  const auto f = [](double x, double y, double z) { return 1 + 2 * x - y + 0.5 * z + 0.25 * x * y - 0.125 * x * z; };
  std::mt19937_64 random(11);
  std::vector<julia::Point> points;
  for (int i = 0; i < 500; ++i)
    points.push_back({std::uniform_real_distribution(0., 23.)(random), std::uniform_real_distribution(0., 15.)(random),
                      std::uniform_real_distribution(0., 31.)(random)});
  points.push_back({23, 15, 31});
  points.push_back({0, 0, 0});
  points.push_back({8, 8, 8});
  for (const auto interpolation : {julia::Interpolation::Trilinear, julia::Interpolation::Quadratic}) {
    const julia::BrickField<Real> field(bricksOfNodes(interpolation, f), indexPlacement());
    const std::vector<Real> values = sampled(field, points);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_NEAR(values[i], f(points[i][0], points[i][1], points[i][2]), 500 * std::numeric_limits<Real>::epsilon())
          << i;
    expectSameBits<Real>([&] { return sampled(field, points); });
  }
}

// The bend is of what is interpolated, not of the nodes.
TYPED_TEST(Kernels, bricksBendBelowTheirKnee) {
  using Real = TypeParam;
  const auto f = [](int x, int y, int z) { return std::sin(1.7 * x) + std::cos(2.3 * y + z); };
  std::mt19937_64 random(12);
  std::vector<julia::Point> points;
  for (int i = 0; i < 500; ++i)
    points.push_back({std::uniform_real_distribution(0., 23.)(random), std::uniform_real_distribution(0., 15.)(random),
                      std::uniform_real_distribution(0., 31.)(random)});
  for (const auto interpolation : {julia::Interpolation::Trilinear, julia::Interpolation::Quadratic}) {
    julia::BrickPlacement placement = indexPlacement();
    const auto bricks = bricksOfNodes(interpolation, f);
    const std::vector<Real> straight = sampled(julia::BrickField<Real>(bricks, placement), points);
    placement.knee = {.at = -0.25, .more = 3.5};
    const julia::BrickField<Real> field(bricks, placement);
    const std::vector<Real> bent = sampled(field, points);
    int below = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      below += straight[i] < Real(-0.25);
      const double v = static_cast<double>(straight[i]);
      EXPECT_NEAR(bent[i], v < -0.25 ? 4.5 * v + 0.875 : v, 20 * std::numeric_limits<Real>::epsilon()) << i;
    }
    EXPECT_GT(below, 100);
    EXPECT_NE(points.size() % 16, 0u);  // the last block of a kernel is not full
    expectSameBits<Real>([&] { return sampled(field, points); });
  }
}

// Between nodes the trilinear slope jumps; the B-spline's does not.
// Promise of options.md: "`quadratic` hides the creases of the distance field"
TYPED_TEST(Kernels, quadraticReadingHasNoCreases) {
  using Real = TypeParam;
  const auto f = [](int x, int y, int z) { return std::sin(1.7 * x) + std::cos(2.3 * y + z); };
  // The change of slope where the stencil moves on, against its change over as short a way within.
  const auto jump = [&](julia::Interpolation interpolation, double at) {
    const julia::BrickField<Real> field(bricksOfNodes(interpolation, f), indexPlacement());
    constexpr double h = 1.0 / 64;
    const std::vector<Real> v = sampled(field, {{at - h, 5.3, 9.1}, {at, 5.3, 9.1}, {at + h, 5.3, 9.1}});
    return std::abs(double(v[2]) - 2 * double(v[1]) + double(v[0])) / h;
  };
  EXPECT_GT(jump(julia::Interpolation::Trilinear, 6), 0.5);
  for (const double at : {6.0, 6.5, 7.5, 8.0}) EXPECT_LT(jump(julia::Interpolation::Quadratic, at), 0.1) << at;
}

/// Places of the kernels of a fit: random ones, and some on the root, beside it, and far away.
template <class Real>
std::vector<Real> coordinates(std::uint64_t seed, std::size_t size, Real root) {
  law_tests::Random random(seed);
  std::vector<Real> x;
  for (std::size_t i = 0; i < size; ++i) x.push_back(static_cast<Real>(random.between(-1, 1)));
  x[3] = x[4] = x[5] = x[6] = root;
  x[5] = std::nextafter(root, Real(2));
  x[7] = Real(1e15);
  return x;
}

TYPED_TEST(Kernels, logDistancesAreRight) {
  using Real = TypeParam;
  constexpr double eps = std::numeric_limits<Real>::epsilon();
  const Real root[3] = {Real(0.1), Real(-0.25), Real(0.7)};
  for (const std::size_t size : {16, 256, 1008})
    for (const Real rest : {Real(0), Real(0.01)}) {
      const auto x = coordinates<Real>(1, size, root[0]), y = coordinates<Real>(2, size, root[1]),
                 z = coordinates<Real>(3, size, root[2]);
      const auto logs = [&] {
        std::vector<Real> out(size);
        julia::kernels::kernels<Real>().logDistances(root, rest, x.data(), y.data(), z.data(), out.data(), size);
        return out;
      };
      expectSameBits<Real>(logs);
      const std::vector<Real> found = logs();
      for (std::size_t i = 0; i < size; ++i) {
        const long double dx = static_cast<long double>(x[i]) - root[0], dy = static_cast<long double>(y[i]) - root[1],
                          dz = static_cast<long double>(z[i]) - root[2];
        const long double square = dx * dx + dy * dy + dz * dz + rest;
        if (square == 0) {
          // As near as can be, and finite.
          EXPECT_TRUE(std::isfinite(found[i])) << i;
          EXPECT_LT(found[i], -30) << i;
          continue;
        }
        // Three eps of the square's terms, half of them in the logarithm, and its own 2 eps.
        const long double expected = std::log(square) / 2;
        EXPECT_LE(std::abs(found[i] - expected), eps * (2 + 2 * std::abs(expected))) << i << " of " << size;
      }
    }
}

TYPED_TEST(Kernels, logSlopesAreRight) {
  using Real = TypeParam;
  constexpr double eps = std::numeric_limits<Real>::epsilon();
  for (const std::size_t size : {16, 256, 1008})
    for (const Real rest : {Real(0), Real(-0.1)}) {
      const Real root[4] = {Real(0.1), Real(-0.25), Real(0.7), rest};
      const auto x = coordinates<Real>(1, size, root[0]), y = coordinates<Real>(2, size, root[1]),
                 z = coordinates<Real>(3, size, root[2]);
      const auto slopes = [&] {
        std::vector<Real> out(4 * size);
        julia::kernels::kernels<Real>().logSlopes(root, x.data(), y.data(), z.data(), out.data(), size);
        return out;
      };
      expectSameBits<Real>(slopes);
      const std::vector<Real> found = slopes();
      for (std::size_t i = 0; i < size; ++i) {
        const long double d[4] = {static_cast<long double>(root[0]) - x[i], static_cast<long double>(root[1]) - y[i],
                                  static_cast<long double>(root[2]) - z[i], rest};
        const long double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3];
        for (std::size_t k = 0; k < 4; ++k) {
          const Real slope = found[k * size + i];
          // Half an eps of the difference, of the quotient and of the product, and two of the square.
          if (square == 0)
            EXPECT_EQ(slope, 0) << i;
          else
            EXPECT_LE(std::abs(slope - d[k] / square), 4 * eps * std::abs(d[k] / square)) << i << ' ' << k;
        }
      }
    }
}

/// Counts that fill the kernels' groups of columns and that do not.
constexpr std::size_t kColumnCounts[] = {0, 1, 3, 4, 5, 8, 11};

TYPED_TEST(Kernels, columnsAreSummedAndMultiplied) {
  using Real = TypeParam;
  constexpr double eps = std::numeric_limits<double>::epsilon();
  for (const std::size_t size : {16, 256})
    for (const std::size_t count : kColumnCounts) {
      law_tests::Random random(4);
      std::vector<Real> columns(count * size);
      std::vector<double> weights(count), start(size), factors(size);
      for (Real& value : columns) value = static_cast<Real>(random.between(-3, 1));
      for (std::vector<double>* values : {&weights, &start, &factors})
        for (double& value : *values) value = random.between(-1, 1) * std::exp(random.between(-3, 3));
      const auto sums = [&] {
        std::vector<double> out = start;
        julia::kernels::kernels<Real>().addColumns(columns.data(), weights.data(), count, out.data(), size);
        return out;
      };
      const auto products = [&] {
        std::vector<double> out(count, -1);
        julia::kernels::kernels<Real>().dotColumns(columns.data(), factors.data(), count, out.data(), size);
        return out;
      };
      expectSameBits<double>(sums);
      expectSameBits<double>(products);
      const std::vector<double> foundSums = sums(), foundProducts = products();
      // n terms: n eps of the sum of their magnitudes at most.
      for (std::size_t i = 0; i < size; ++i) {
        long double sum = start[i], magnitude = std::abs(sum);
        for (std::size_t j = 0; j < count; ++j) {
          const long double term = static_cast<long double>(weights[j]) * columns[j * size + i];
          sum += term;
          magnitude += std::abs(term);
        }
        EXPECT_LE(std::abs(foundSums[i] - sum), eps * static_cast<double>(count + 1) * magnitude) << i << ' ' << count;
      }
      for (std::size_t j = 0; j < count; ++j) {
        long double sum = 0, magnitude = 0;
        for (std::size_t i = 0; i < size; ++i) {
          const long double term = static_cast<long double>(factors[i]) * columns[j * size + i];
          sum += term;
          magnitude += std::abs(term);
        }
        EXPECT_LE(std::abs(foundProducts[j] - sum), eps * static_cast<double>(size) * magnitude) << j << ' ' << count;
      }
    }
}

TYPED_TEST(Kernels, ranksAreClosedInOrder) {
  using Real = TypeParam;
  const KeepInstructionSet keep;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> value(-2, 2);
  for (const InstructionSet set : julia::availableInstructionSets()) {
    julia::setInstructionSet(set);
    for (const std::size_t size : {0u, 1u, 15u, 16u, 17u, 255u, 256u, 257u, 1000u, 2048u})
      for (const bool traps : {false, true}) {
        std::vector<Real> l(size), first(size), second(size);
        std::vector<std::uint32_t> index(size);
        for (std::size_t i = 0; i < size; ++i) {
          l[i] = i % 7 == 0 ? -std::numeric_limits<Real>::infinity() : static_cast<Real>(value(random));
          first[i] = static_cast<Real>(i);
          second[i] = static_cast<Real>(2 * i);
          index[i] = static_cast<std::uint32_t>(3 * i);
        }
        std::vector<Real> expected;
        std::vector<std::uint32_t> places;
        for (std::size_t i = 0; i < size; ++i)
          if (l[i] < Real(1) && (!traps || l[i] > Real(-1))) {
            expected.push_back(l[i]);
            places.push_back(static_cast<std::uint32_t>(i));
          }
        Real* const rows[2] = {first.data(), second.data()};
        const std::size_t kept =
            julia::kernels::kernels<Real>().compact(Real(1), traps, Real(-1), l.data(), index.data(), rows, 2, size);
        ASSERT_EQ(kept, expected.size()) << size;
        for (std::size_t k = 0; k < kept; ++k) {
          EXPECT_EQ(l[k], expected[k]);
          EXPECT_EQ(first[k], static_cast<Real>(places[k]));
          EXPECT_EQ(second[k], static_cast<Real>(2 * places[k]));
          EXPECT_EQ(index[k], 3 * places[k]);
        }
      }
  }
}

TYPED_TEST(Kernels, tilesAreMultiplied) {
  using Real = TypeParam;
  constexpr std::size_t kTile = julia::kernels::kTile;
  constexpr double eps = std::numeric_limits<Real>::epsilon();
  for (const std::size_t depth : {0, 1, 5, 256}) {
    law_tests::Random random(5);
    // At an odd address: rows of tiles lie anywhere.
    std::vector<Real> a(depth * kTile + 1), b(depth * kTile + 1);
    for (std::vector<Real>* values : {&a, &b})
      for (Real& value : *values) value = static_cast<Real>(random.between(-3, 3));
    const auto product = [&] {
      std::vector<Real> out(kTile * kTile, -1);
      julia::kernels::kernels<Real>().tileProduct(a.data() + 1, b.data() + 1, depth, out.data());
      return out;
    };
    expectSameBits<Real>(product);
    const std::vector<Real> found = product();
    for (std::size_t i = 0; i < kTile; ++i)
      for (std::size_t j = 0; j < kTile; ++j) {
        long double sum = 0, magnitude = 0;
        for (std::size_t k = 0; k < depth; ++k) {
          const long double term = static_cast<long double>(a[1 + k * kTile + i]) * b[1 + k * kTile + j];
          sum += term;
          magnitude += std::abs(term);
        }
        EXPECT_LE(std::abs(found[i * kTile + j] - sum), eps * static_cast<double>(depth) * magnitude)
            << i << ' ' << j << " of depth " << depth;
      }
  }
}

TEST(BrickField, positionsBeyondTheBoxAreThoseOfItsFace) {
  const auto f = [](int x, int y, int z) { return x + 100 * y + 10000 * z; };
  const julia::BrickField<double> field(bricksOfNodes(julia::Interpolation::Trilinear, f), indexPlacement());
  const auto values = sampled<double>(field, {{-5, 2, 3}, {1e30, 2, 3}, {4, -1e300, 31}, {23, 15, 99}});
  EXPECT_EQ(values, (std::vector<double>{f(0, 2, 3), f(23, 2, 3), f(4, 0, 31), f(23, 15, 31)}));
}

TEST(BrickField, refusesWhatDoesNotFit) {
  auto bricks = std::make_shared<julia::Bricks>();
  EXPECT_THROW((julia::BrickField<float>(bricks, indexPlacement())), std::invalid_argument);
  bricks->count = {1, 1, 1};
  bricks->brickAt = {1};
  bricks->values.resize(bricks->size());
  EXPECT_THROW((julia::BrickField<float>(bricks, julia::BrickPlacement{})), std::invalid_argument);
  bricks->brickAt = {0};
  EXPECT_NO_THROW((julia::BrickField<float>(bricks, julia::BrickPlacement{})));
  EXPECT_THROW((julia::BrickField<float>(bricks, indexPlacement())), std::invalid_argument);
  // It would not grow with the values any more, which bounds need.
  EXPECT_THROW((julia::BrickField<float>(bricks, julia::BrickPlacement{.knee = {.at = 0, .more = -0.5}})),
               std::invalid_argument);
}

TEST(InstructionSets, theLastOneIsInUseUnlessAnotherIsSet) {
  const KeepInstructionSet keep;
  const auto available = julia::availableInstructionSets();
  ASSERT_FALSE(available.empty());
  EXPECT_EQ(available.front(), InstructionSet::Portable);
  for (const InstructionSet set : available) {
    julia::setInstructionSet(set);
    EXPECT_EQ(julia::instructionSet(), set);
  }
}

}  // namespace
