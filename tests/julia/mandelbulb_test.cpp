// SPDX-License-Identifier: Apache-2.0
// Triplex powers, and the quadratic sets of quaternions beside them: against the reference, and their symmetries.
#include "julia/mandelbulb.h"

#include "julia/cross_map.h"
#include "julia/evaluator.h"
#include "julia/quadratic_map.h"
#include "support/float128.h"
#include "support/reference.h"
#include "support/same_bits.h"
#include "support/spatial_orbits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

namespace {

namespace reference = julia::reference;
using julia::FieldEvaluator;
using julia::Mandelbulb;
using julia::MandelbulbOptions;
using julia::OrbitOptions;
using julia::Point;
using julia::Quaternion;
using julia::QuaternionBatch;
using julia::TriplexAngle;
using law_tests::evaluated;
using law_tests::FieldValues;
using law_tests::Long;
using law_tests::LongVector;
using law_tests::pointsInBox;
using law_tests::text;

constexpr TriplexAngle kAngles[] = {TriplexAngle::AbovePlane, TriplexAngle::FromPole};

template <class Real>
std::unique_ptr<FieldEvaluator> bulbEvaluator(const MandelbulbOptions& options, const OrbitOptions& orbit) {
  return julia::makeFieldEvaluator<Real>(std::make_shared<Mandelbulb<Real>>(options), {}, orbit);
}

template <class Real>
QuaternionBatch<Real> powers(const MandelbulbOptions& options, const std::vector<Point>& points) {
  QuaternionBatch<Real> power;
  Mandelbulb<Real>(options).direction(law_tests::batchOf<Real>(points), power);
  return power;
}

/// Of p^n, in units of epsilon: squarings multiply a relative error by n; angles and logarithms are rounded and
/// multiplied by n.
Long powerRounding(double n, const LongVector& p) {
  const Long r = law_tests::length(p);
  return (8 * std::abs(n) + 16) * std::pow(r, static_cast<Long>(n)) * (1 + std::abs(std::log(r)));
}

template <class Real>
class Mandelbulbs : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Mandelbulbs, Reals);

TYPED_TEST(Mandelbulbs, powersAreThoseOfTheAngles) {
  using Real = TypeParam;
  std::vector<Point> points = pointsInBox(71, 1000, 1.5);
  for (const double x : {0.5, -0.5, 0.25}) {
    points.push_back({x, 0, 0});
    points.push_back({0, x, 0});
    points.push_back({0, 0, x});
    points.push_back({x, x, 0});
    points.push_back({0, x, x});
  }
  for (const TriplexAngle angle : kAngles)
    for (const double n : {1., 2., 3., 5., 8., 17., 64., 65., 2.5, 8.25, 0.5, -1., -2.75}) {
      const QuaternionBatch<Real> found = powers<Real>({.power = n, .angle = angle}, points);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const LongVector at = law_tests::longVector(points[i]);
        const LongVector wanted = reference::triplexPower<Long>(at, n, angle);
        const Long allowed =
            powerRounding(n, at) * std::numeric_limits<Real>::epsilon() + 2 * std::numeric_limits<Real>::min();
        EXPECT_NEAR(found.a[i], wanted[0], allowed) << n << " at " << text(points[i]);
        EXPECT_NEAR(found.b[i], wanted[1], allowed) << n << " at " << text(points[i]);
        EXPECT_NEAR(found.c[i], wanted[2], allowed) << n << " at " << text(points[i]);
        EXPECT_EQ(found.d[i], 0);
      }
    }
}

TYPED_TEST(Mandelbulbs, powersOfZero) {
  using Real = TypeParam;
  for (const TriplexAngle angle : kAngles)
    for (const double n : {2., 8., 8.5, 0.5, 1.})
      EXPECT_EQ((powers<Real>({.power = n, .angle = angle}, {{0, 0, 0}}).get(0)), Quaternion<Real>{}) << n;
  // 0 to a negative power has escaped.
  const FieldValues values = evaluated(*bulbEvaluator<Real>({.power = -2}, {}), {{0, 0, 0}});
  EXPECT_EQ(values.field[0], julia::kFieldLimit);
  EXPECT_EQ(values.iterations[0], 1);
}

// Promise: "Tests compare everything fast ..."
TYPED_TEST(Mandelbulbs, orbitsAreTheReferences) {
  using Real = TypeParam;
  const OrbitOptions orbit{.maxIterations = 4, .escapeRadius = 2};
  for (const TriplexAngle angle : kAngles)
    for (const double n : {2., 8., 3.5})
      for (const std::optional<Point>& constant : {std::optional<Point>(), std::optional<Point>({-0.25, 0.5, 0.125})}) {
        const MandelbulbOptions options{.power = n, .angle = angle, .constant = constant};
        const auto stepOf = [&](const LongVector& start) { return reference::mandelbulbStep<Long>(options, start); };
        const auto rounding = [&](const LongVector& p, const LongVector& next) {
          return powerRounding(n, p) + 2 * (law_tests::length(next) + 2);
        };
        law_tests::expectReferenceOrbits<Real>(*bulbEvaluator<Real>(options, orbit), stepOf, rounding,
                                               pointsInBox(72, 500, 1.25), orbit, 0.8, "power " + std::to_string(n));
      }
}

// Off the set where the pair is not defined.
// Promise: "f x g of the pair A is the square ..."
TYPED_TEST(Mandelbulbs, powerTwoIsPairAOfTheCrossProducts) {
  using Real = TypeParam;
  const std::vector<Point> points = pointsInBox(73, 5000, 1.25);
  const OrbitOptions orbit{.maxIterations = 4, .escapeRadius = 2};
  const FieldValues power = evaluated(*bulbEvaluator<Real>({.power = 2}, orbit), points);
  const FieldValues pair = evaluated(
      *julia::makeFieldEvaluator<Real>(std::make_shared<julia::CrossMap<Real>>(julia::CrossOptions{}), {}, orbit),
      points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(power.field[i]) < 1e4 * std::numeric_limits<Real>::epsilon()) continue;
    EXPECT_EQ(power.field[i] < 0, pair.field[i] < 0) << text(points[i]);
    EXPECT_EQ(power.iterations[i], pair.iterations[i]) << text(points[i]);
  }
}

// Promise: "any size of a batch, and any ..."
TYPED_TEST(Mandelbulbs, areTheSameOnAllInstructionSets) {
  using Real = TypeParam;
  std::vector<Point> points = pointsInBox(74, 1500, 1.5);
  for (const double x : {0., 1e-42, 1e-310, 0.5})
    for (const double y : {0., 0.5, -0.5, 1e-30}) points.push_back({x, y, x - y});
  for (const TriplexAngle angle : kAngles)
    for (const double n : {2., 7., 8., 8.5, -1.5}) {
      const auto evaluator = bulbEvaluator<Real>({.power = n, .angle = angle}, {.maxIterations = 8, .escapeRadius = 2});
      law_tests::expectSameBits<double>([&] { return evaluated(*evaluator, points).field; });
    }
  const auto quadratic = julia::makeFieldEvaluator<Real>(std::make_shared<julia::QuadraticMandelbrot<Real>>(),
                                                         {.slice = 0.25}, {.maxIterations = 12, .escapeRadius = 2});
  law_tests::expectSameBits<double>([&] { return evaluated(*quadratic, points).field; });
}

// A power that leaves the range of Real has escaped, and F is finite.
TYPED_TEST(Mandelbulbs, overflowIsEscape) {
  for (const double n : {64., 99.5}) {
    const FieldValues values = evaluated(
        *bulbEvaluator<TypeParam>({.power = n}, {.maxIterations = 5, .escapeRadius = 1e8}), {{1e5, 2e5, 3e5}});
    EXPECT_TRUE(std::isfinite(values.field[0])) << n;
    EXPECT_GT(values.field[0], 0) << n;
    EXPECT_EQ(values.iterations[0], 1) << n;
  }
}

// On rays from the origin: all that lies beyond the bound has escaped, and not only what lies beyond the radius.
// Promise: "a smaller ball is searched, which is proved ..."
TYPED_TEST(Mandelbulbs, beyondTheBoundAllHasEscaped) {
  using Real = TypeParam;
  for (const double n : {2., 3.5, 8.})
    for (const int iterations : {1, 3, 20})
      for (const std::optional<Point>& constant : {std::optional<Point>(), std::optional<Point>({-0.75, 0.5, 0.25})}) {
        const OrbitOptions orbit{.maxIterations = iterations, .escapeRadius = 20};
        const MandelbulbOptions options{.power = n, .constant = constant};
        const double bound = julia::triplexBound(options, iterations, orbit.escapeRadius);
        EXPECT_LT(bound, 6) << n;
        std::vector<Point> points = pointsInBox(76, 2000, 1);
        std::erase_if(points, [](const Point& p) { return std::hypot(p[0], p[1], p[2]) < 0.01; });
        for (std::size_t i = 0; i < points.size(); ++i) {
          const double scale =
              bound * (1 + 1e-6 + 0.5 * i / points.size()) / std::hypot(points[i][0], points[i][1], points[i][2]);
          for (double& x : points[i]) x *= scale;
        }
        for (const double field : evaluated(*bulbEvaluator<Real>(options, orbit), points).field)
          EXPECT_GE(field, 0) << n << ' ' << iterations;
      }
  EXPECT_NEAR(julia::triplexBound({.power = 2}, 1000, 2), 2, 1e-9);
  EXPECT_EQ(julia::triplexBound({.power = 1.5}, 1000, 2), 2);
}

TEST(MandelbulbInput, isRefused) {
  for (const double n : {std::nan(""), 101., -1e9, HUGE_VAL})
    EXPECT_THROW(Mandelbulb<float>({.power = n}), std::invalid_argument) << n;
  EXPECT_THROW(Mandelbulb<float>({.constant = Point{0, HUGE_VAL, 0}}), std::invalid_argument);
}

// ------------------------------------------------------------------------------------------------ quadratic, [x y z S]

TYPED_TEST(Mandelbulbs, quadraticMandelbrotOrbitsAreTheReferences) {
  using Real = TypeParam;
  const julia::Embedding embedding{.slice = 0.125, .dropped = julia::DropAxis::J};
  const OrbitOptions orbit{.maxIterations = 5, .escapeRadius = 2};
  const auto evaluator =
      julia::makeFieldEvaluator<Real>(std::make_shared<julia::QuadraticMandelbrot<Real>>(), embedding, orbit);
  const std::vector<Point> points = pointsInBox(75, 2000, 1.5);
  const FieldValues values = evaluated(*evaluator, points);
  int judged = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Quaternion<Long> start = embedding.quaternion<Long>(points[i]);
    const auto map = reference::quadraticMap<Long>(start.template as<double>());
    const reference::Orbit<Long> expected = reference::orbit<Long>(map, start, orbit.maxIterations, 2);
    // Five squarings of numbers up to 2, each of which makes an error at most four times as large and adds a few.
    const double wanted = static_cast<double>(expected.logModulus - std::log(2.0L));
    const double allowed = 2e4 * static_cast<double>(std::numeric_limits<Real>::epsilon());
    if (std::abs(wanted) < allowed || !(expected.logModulus > -3)) continue;
    ++judged;
    EXPECT_EQ(values.iterations[i], expected.iterations) << text(points[i]);
    EXPECT_NEAR(values.field[i], wanted, allowed) << text(points[i]);
  }
  EXPECT_GT(judged, 1900);
}

// (y, z) of one length in five directions: 5^2 is 3^2 + 4^2, and all squares are exact.
template <class Real>
void expectRotated(const FieldEvaluator& evaluator) {
  constexpr double k = 1. / 32;
  std::vector<Point> points;
  for (int x = -60; x <= 60; ++x)
    for (const int size : {1, 2, 3, 4})
      for (const Point& p : {Point{0, 5, 0}, Point{0, 0, 5}, Point{0, 3, 4}, Point{0, -4, 3}, Point{0, -3, -4}})
        points.push_back({x * k, size * p[1] * k, size * p[2] * k});
  const FieldValues values = evaluated(evaluator, points);
  for (std::size_t i = 0; i < points.size(); i += 5)
    for (std::size_t j = i + 1; j < i + 5; ++j) {
      EXPECT_EQ(values.field[j] < 0, values.field[i] < 0) << text(points[i]) << ' ' << text(points[j]);
      EXPECT_EQ(values.iterations[j], values.iterations[i]) << text(points[i]) << ' ' << text(points[j]);
      EXPECT_NEAR(values.field[j], values.field[i], 1e5 * static_cast<double>(std::numeric_limits<Real>::epsilon()))
          << text(points[i]) << ' ' << text(points[j]);
    }
}

TYPED_TEST(Mandelbulbs, quadraticSetsWithRealConstantsAreRotationallySymmetric) {
  using Real = TypeParam;
  const OrbitOptions orbit{.maxIterations = 6, .escapeRadius = 2};
  for (const double slice : {0., 0.375}) {
    expectRotated<Real>(*julia::makeFieldEvaluator<Real>(std::make_shared<julia::QuadraticMandelbrot<Real>>(),
                                                         {.slice = slice}, orbit));
    for (const double c : {-1., 0.25, -0.75})
      expectRotated<Real>(*julia::makeFieldEvaluator<Real>(
          std::make_shared<julia::QuadraticMap<Real>>(Quaternion<double>{c, 0, 0, 0}), {.slice = slice}, orbit));
  }
}

// The point's distance from the real axis is the complex imaginary part.
TEST(QuadraticMandelbrot, hasTheComplexSetInEachPlaneThroughTheRealAxis) {
  std::vector<Point> points, flat;
  for (int i = 0; i < 160; ++i)
    for (int j = -60; j < 60; ++j) {
      const double x = -2 + i / 64., y = j / 64.;
      points.push_back({x, 0.6 * y, 0.8 * y});
      flat.push_back({x, y, 0});
    }
  const OrbitOptions orbit{.maxIterations = 30, .escapeRadius = 2};
  const auto quaternion =
      julia::makeFieldEvaluator<double>(std::make_shared<julia::QuadraticMandelbrot<double>>(), {}, orbit);
  const auto complex = julia::makeFieldEvaluator<double>(
      std::make_shared<julia::CrossMap<double>>(julia::CrossOptions{.pair = julia::CrossPair::D}), {}, orbit);
  const FieldValues tilted = evaluated(*quaternion, points), expected = evaluated(*complex, flat);
  int inside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    inside += expected.field[i] < 0 ? 1 : 0;
    if (std::abs(expected.field[i]) < 1e-9) continue;
    EXPECT_EQ(tilted.field[i] < 0, expected.field[i] < 0) << text(flat[i]);
  }
  EXPECT_GT(inside, 3000);
}

}  // namespace
