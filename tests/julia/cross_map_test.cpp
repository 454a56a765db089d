// SPDX-License-Identifier: Apache-2.0
// The cross-product maps: against the trigonometric reference, where the answer is known, and where nothing is defined.
#include "julia/cross_map.h"

#include "julia/evaluator.h"
#include "julia/mandelbulb.h"
#include "support/float128.h"
#include "support/same_bits.h"
#include "support/spatial_orbits.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace reference = julia::reference;
using julia::CrossMap;
using julia::CrossOptions;
using julia::CrossPair;
using julia::CrossScheme;
using julia::FieldEvaluator;
using julia::OrbitOptions;
using julia::Point;
using julia::Quaternion;
using julia::QuaternionBatch;
using law_tests::batchOf;
using law_tests::crossEvaluator;
using law_tests::evaluated;
using law_tests::FieldValues;
using law_tests::Long;
using law_tests::LongVector;
using law_tests::pointsInBox;
using law_tests::text;

constexpr CrossPair kPairs[] = {CrossPair::A, CrossPair::APrime, CrossPair::B,
                                CrossPair::C, CrossPair::D,      CrossPair::E};
constexpr CrossScheme kSchemes[] = {CrossScheme::FixedFactor, CrossScheme::Mandelbrot, CrossScheme::Julia};

std::string nameOf(CrossPair pair, CrossScheme scheme = CrossScheme::Mandelbrot) {
  return std::string(std::array{"A", "A'", "B", "C", "D", "E", "user"}[static_cast<std::size_t>(pair)]) + " scheme " +
         std::to_string(static_cast<int>(scheme) + 3);
}

/// What one step may be off by, in units of epsilon: a dozen operations on terms of these sizes.
Long stepRounding(CrossPair pair, const LongVector& p) {
  const Long r = law_tests::length(p);
  switch (pair) {
    case CrossPair::B: return 12;
    case CrossPair::C: return 12 * r * r;
    case CrossPair::E: return 12 * r * r * (1 + r);
    default: return 16 * r * r;
  }
}

template <class Real>
class CrossMaps : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(CrossMaps, Reals);

// ---------------------------------------------------------------------------------------------- against the reference

TYPED_TEST(CrossMaps, productsAreThoseOfTheTrigonometricPairs) {
  using Real = TypeParam;
  const std::vector<Point> points = pointsInBox(61, 2000, 3);
  const QuaternionBatch<Real> p = batchOf<Real>(points);
  for (const CrossPair pair : kPairs) {
    QuaternionBatch<Real> product;
    CrossMap<Real>({.pair = pair}).direction(p, product);
    const reference::FunctionPair<Long> functions = reference::functionPair<Long>(pair);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const LongVector at = law_tests::longVector(points[i]);
      const LongVector wanted = reference::cross(*functions.f(at), *functions.g(at));
      const Quaternion<Real> found = product.get(i);
      const Long allowed = stepRounding(pair, at) * std::numeric_limits<Real>::epsilon();
      EXPECT_NEAR(found.a, wanted[0], allowed) << nameOf(pair) << " at " << text(points[i]);
      EXPECT_NEAR(found.b, wanted[1], allowed) << nameOf(pair) << " at " << text(points[i]);
      EXPECT_NEAR(found.c, wanted[2], allowed) << nameOf(pair) << " at " << text(points[i]);
      EXPECT_EQ(found.d, 0);
    }
  }
}

// Promise of design.md: "f x g of the pair A is the square of triplex numbers, the Mandelbulb's power 2"
TYPED_TEST(CrossMaps, pairAIsTheTriplexSquare) {
  using Real = TypeParam;
  const std::vector<Point> points = pointsInBox(62, 2000, 3);
  const QuaternionBatch<Real> p = batchOf<Real>(points);
  QuaternionBatch<Real> square, mirrored;
  CrossMap<Real>({.pair = CrossPair::A}).direction(p, square);
  CrossMap<Real>({.pair = CrossPair::APrime}).direction(p, mirrored);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LongVector at = law_tests::longVector(points[i]);
    const LongVector wanted = reference::triplexPower<Long>(at, 2, julia::TriplexAngle::AbovePlane);
    const Long allowed = stepRounding(CrossPair::A, at) * std::numeric_limits<Real>::epsilon();
    EXPECT_NEAR(square.a[i], wanted[0], allowed) << text(points[i]);
    EXPECT_NEAR(square.b[i], wanted[1], allowed) << text(points[i]);
    EXPECT_NEAR(square.c[i], wanted[2], allowed) << text(points[i]);
    EXPECT_EQ(mirrored.get(i), (Quaternion<Real>{square.a[i], square.b[i], -square.c[i], 0})) << text(points[i]);
  }
}

// Promise: "Tests compare everything fast ..."
TYPED_TEST(CrossMaps, orbitsAreTheReferences) {
  using Real = TypeParam;
  const Point constant{-0.75, 0.25, 0.125};
  for (const CrossPair pair : kPairs)
    for (const CrossScheme scheme : kSchemes) {
      const OrbitOptions orbit{.maxIterations = 6, .escapeRadius = 4};
      const reference::FunctionPair<Long> functions = reference::functionPair<Long>(pair);
      Long second = 0;  // |g| of the orbit at hand, of any size where cos 2phi is near 0
      const auto stepOf = [&](const LongVector& start) {
        const auto g = functions.g(start);
        second = g ? law_tests::length(*g) : 0;
        return reference::crossStep<Long>(functions, scheme, start, law_tests::longVector(constant));
      };
      const auto rounding = [&](const LongVector& p, const LongVector& next) {
        if (scheme != CrossScheme::FixedFactor) return stepRounding(pair, p) + 2 * (law_tests::length(next) + 4);
        return stepRounding(pair, p) + 16 * (second + 1) * law_tests::length(p);
      };
      law_tests::expectReferenceOrbits<Real>(
          *crossEvaluator<Real>({.pair = pair, .scheme = scheme, .constant = constant}, orbit), stepOf, rounding,
          pointsInBox(63, 600, 1.25), orbit, sizeof(Real) == 4 ? 0.4 : 0.9, nameOf(pair, scheme));
    }
}

// Promise: "any size of a batch, and any ..."
TYPED_TEST(CrossMaps, areTheSameOnAllInstructionSets) {
  using Real = TypeParam;
  std::vector<Point> points = pointsInBox(64, 1500, 2);
  for (const double x : {0., 1e-42, 1e-310, 0.5})
    for (const double y : {0., 0.5, -0.5, 1e-30}) points.push_back({x, y, x - y});
  for (const CrossPair pair : kPairs)
    for (const CrossScheme scheme : kSchemes) {
      const auto evaluator = crossEvaluator<Real>({.pair = pair, .scheme = scheme, .constant = {-1, 0.1, 0.3}},
                                                  {.maxIterations = 10, .escapeRadius = 5});
      law_tests::expectSameBits<double>([&] { return evaluated(*evaluator, points).field; });
    }
}

TYPED_TEST(CrossMaps, aPointDoesNotDependOnItsBatch) {
  using Real = TypeParam;
  const std::vector<Point> points = pointsInBox(65, 3000, 2);
  for (const CrossScheme scheme : kSchemes) {
    const auto evaluator = crossEvaluator<Real>({.pair = CrossPair::C, .scheme = scheme}, {.maxIterations = 9});
    const FieldValues together = evaluated(*evaluator, points);
    for (std::size_t i = 0; i < points.size(); i += 7) {
      const FieldValues alone = evaluated(*evaluator, {points[i]});
      EXPECT_EQ(alone.field[0], together.field[i]) << text(points[i]);
      EXPECT_EQ(alone.iterations[0], together.iterations[i]) << text(points[i]);
    }
  }
}

// ------------------------------------------------------------------------------------------- where nothing is defined

// Promise of sets.md: A and A' "are not defined where |x| = |y|. These points count as outside"
TYPED_TEST(CrossMaps, pairAEscapesWhereItIsNotDefined) {
  using Real = TypeParam;
  std::vector<Point> points;
  for (const double x : {1e-40, 1e-20, 0.25, 1.0})
    for (const double sx : {-1., 1.})
      for (const double sy : {-1., 1.})
        for (const double z : {0., 0.5, -0.125}) points.push_back({sx * x, sy * x, z});
  for (const CrossPair pair : {CrossPair::A, CrossPair::APrime})
    for (const CrossScheme scheme : kSchemes) {
      const FieldValues values = evaluated(*crossEvaluator<Real>({.pair = pair, .scheme = scheme}, {}), points);
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(values.field[i], julia::kFieldLimit) << nameOf(pair, scheme) << " at " << text(points[i]);
        EXPECT_EQ(values.iterations[i], 1) << nameOf(pair, scheme) << " at " << text(points[i]);
      }
    }
}

// An iterate, not the point: 0 -> (1/4, 1/4, 1/8), which is undefined.
// Promise: A and A' "are not defined ..."
TYPED_TEST(CrossMaps, anIterateMayBeUndefined) {
  const auto evaluator = crossEvaluator<TypeParam>({.scheme = CrossScheme::Julia, .constant = {0.25, 0.25, 0.125}},
                                                   {.maxIterations = 10, .escapeRadius = 2});
  const FieldValues values = evaluated(*evaluator, {{0, 0, 0}});
  EXPECT_EQ(values.field[0], julia::kFieldLimit);
  EXPECT_EQ(values.iterations[0], 2);
}

TYPED_TEST(CrossMaps, anglesThatDoNotExistAreZero) {
  using Real = TypeParam;
  const QuaternionBatch<Real> p = batchOf<Real>({{0, 0, 0}, {0, 0, 0.5}, {0, 0, -0.5}, {0, 0, 1e-30}});
  for (const CrossPair pair : {CrossPair::A, CrossPair::APrime, CrossPair::D}) {
    QuaternionBatch<Real> product;
    CrossMap<Real>({.pair = pair}).direction(p, product);
    // cos 2phi = 1, and cos 2theta = -1 off the origin.
    const Real x = pair == CrossPair::D ? Real(0.25) : Real(-0.25);
    EXPECT_EQ(product.get(0), Quaternion<Real>{});
    EXPECT_EQ(product.get(1), (Quaternion<Real>{x, 0, 0, 0})) << nameOf(pair);
    EXPECT_EQ(product.get(2), (Quaternion<Real>{x, 0, 0, 0})) << nameOf(pair);
    EXPECT_LE(std::abs(product.a[3]), 1e-30) << nameOf(pair);
  }
}

// Squares of such coordinates underflow: still no point of them is undefined or anything but near 0.
TYPED_TEST(CrossMaps, tinyPointsAreOrdinary) {
  using Real = TypeParam;
  const double tiny = sizeof(Real) == 4 ? 1e-42 : 1e-320;
  const std::vector<Point> points{{tiny, 0, 0}, {0, tiny, 0.5}, {tiny, 2 * tiny, 1}, {tiny, -2 * tiny, tiny}};
  const reference::FunctionPair<Long> a = reference::functionPair<Long>(CrossPair::A);
  QuaternionBatch<Real> product;
  CrossMap<Real>({.pair = CrossPair::A}).direction(batchOf<Real>(points), product);
  for (std::size_t i = 0; i < points.size(); ++i) {
    // As Real has them.
    LongVector at{};
    for (std::size_t k = 0; k < 3; ++k) at[k] = static_cast<Real>(points[i][k]);
    const LongVector wanted = reference::cross(*a.f(at), *a.g(at));
    const double allowed = 16 * static_cast<double>(std::numeric_limits<Real>::epsilon());
    EXPECT_NEAR(product.a[i], wanted[0], allowed) << i;
    EXPECT_NEAR(product.b[i], wanted[1], allowed) << i;
    EXPECT_NEAR(product.c[i], wanted[2], allowed) << i;
  }
}

// --------------------------------------------------------------------------------------------------- what is known

/// The complex quadratic orbit in plain Real.
template <class Real>
FieldValues complexQuadratic(const std::vector<Point>& points, bool mandelbrot, const Point& constant, int n,
                             double r) {
  FieldValues values;
  for (const Point& point : points) {
    Real x = static_cast<Real>(point[0]), y = static_cast<Real>(point[1]);
    const Real cx = mandelbrot ? x : static_cast<Real>(constant[0]),
               cy = mandelbrot ? y : static_cast<Real>(constant[1]);
    int i = 0;
    for (; i < n && x * x + y * y < static_cast<Real>(r * r); ++i) {
      const Real nextX = x * x - y * y + cx;
      y = 2 * (x * y) + cy;
      x = nextX;
    }
    values.field.push_back(std::log(std::hypot(x, y) / r));
    values.iterations.push_back(i);
  }
  return values;
}

std::vector<Point> planeGrid(int n, double lowX, double lowY, double step) {
  std::vector<Point> points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) points.push_back({lowX + i * step, lowY + j * step, 0});
  return points;
}

TYPED_TEST(CrossMaps, pairDInThePlaneIsTheComplexSquarePointForPoint) {
  using Real = TypeParam;
  const std::vector<Point> points = planeGrid(200, -1.59375, -1.59375, 1. / 64);
  for (const bool mandelbrot : {false, true})
    for (const Point& c : {Point{-1, 0, 0}, Point{-0.125, 0.75, 0}, Point{0.375, 0.125, 0}}) {
      const FieldValues expected = complexQuadratic<Real>(points, mandelbrot, c, 60, 2);
      const FieldValues found =
          evaluated(*crossEvaluator<Real>({.pair = CrossPair::D,
                                           .scheme = mandelbrot ? CrossScheme::Mandelbrot : CrossScheme::Julia,
                                           .constant = c},
                                          {.maxIterations = 60, .escapeRadius = 2}),
                    points);
      int inside = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        inside += expected.field[i] < 0 ? 1 : 0;
        // |p| = 2 to the last bit is either; there are none but (+-2, 0).
        EXPECT_EQ(found.field[i] < 0, expected.field[i] < 0) << text(points[i]);
        EXPECT_EQ(found.iterations[i], expected.iterations[i]) << text(points[i]);
      }
      EXPECT_GT(inside, 100);
    }
}

// 1.5066 (Mitchell 2001 and others, by counting). 600 nodes a side and 1000 steps give 1.5107: what escapes later than
// that is counted too.
TYPED_TEST(CrossMaps, pairDInThePlaneHasTheMandelbrotSetsArea) {
  constexpr int kNodes = 600, kIterations = 1000;
  constexpr double kStep = 2.5 / kNodes;
  const std::vector<Point> points = planeGrid(kNodes, -2 + kStep / 3, -1.25 + kStep / 3, kStep);
  const FieldValues values = evaluated(
      *crossEvaluator<TypeParam>({.pair = CrossPair::D}, {.maxIterations = kIterations, .escapeRadius = 2}), points);
  int inside = 0;
  for (const double f : values.field) inside += f < 0 ? 1 : 0;
  const double area = inside * kStep * kStep;
  this->RecordProperty("area", std::to_string(area));
  EXPECT_NEAR(area, 1.5066, 0.01 * 1.5066);
}

// The defaults of [ZB25] say when: i counts the products, f(c) x g(c) among them.
TEST(CrossScheme, iterationsCountProducts) {
  // Pair D on the x axis: x -> x^2; 1.25 -> 1.5625 -> 2.44.
  const Point x{1.25, 0, 0};
  const CrossOptions square{.pair = CrossPair::D, .scheme = CrossScheme::Julia};
  EXPECT_EQ(evaluated(*crossEvaluator<double>(square, {.maxIterations = 10, .escapeRadius = 2}), {x}).iterations[0], 2);
  EXPECT_LT(evaluated(*crossEvaluator<double>(square, {.maxIterations = 1, .escapeRadius = 2}), {x}).field[0], 0);
  EXPECT_GT(evaluated(*crossEvaluator<double>(square, {.maxIterations = 2, .escapeRadius = 2}), {x}).field[0], 0);
  // Scheme (3) of D: p_0 = (1.5625, 0, 0), then x (0, 0, 1): (0, -1.5625, 0), and so on around.
  const CrossOptions fixed{.pair = CrossPair::D, .scheme = CrossScheme::FixedFactor};
  for (const int n : {1, 2, 7}) {
    const FieldValues values = evaluated(*crossEvaluator<double>(fixed, {.maxIterations = n, .escapeRadius = 2}), {x});
    EXPECT_EQ(values.iterations[0], n);
    EXPECT_NEAR(values.field[0], std::log(1.5625 / 2), 1e-15);
  }
  // Beyond the radius before any step.
  const FieldValues out =
      evaluated(*crossEvaluator<double>(fixed, {.maxIterations = 3, .escapeRadius = 2}), {{0, 2, 0}});
  EXPECT_EQ(out.iterations[0], 0);
  EXPECT_GE(out.field[0], 0);
}

TYPED_TEST(CrossMaps, versorsPointAlongTheProduct) {
  using Real = TypeParam;
  const std::vector<Point> points = pointsInBox(66, 300, 1.5);
  for (const CrossScheme scheme : kSchemes) {
    const auto evaluator = crossEvaluator<Real>({.pair = CrossPair::C, .scheme = scheme, .constant = {1, 2, 3}}, {});
    std::vector<Quaternion<double>> versors(points.size());
    evaluator->versors(points, versors);
    const reference::FunctionPair<Long> functions = reference::functionPair<Long>(CrossPair::C);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const LongVector at = law_tests::longVector(points[i]);
      const LongVector product = reference::cross(*functions.f(at), *functions.g(at));
      const Long size = law_tests::length(product),
                 allowed = std::numeric_limits<Real>::epsilon() * (4 + stepRounding(CrossPair::C, at) / size);
      EXPECT_NEAR(versors[i].a, product[0] / size, allowed) << text(points[i]);
      EXPECT_NEAR(versors[i].b, product[1] / size, allowed) << text(points[i]);
      EXPECT_NEAR(versors[i].c, product[2] / size, allowed) << text(points[i]);
      EXPECT_EQ(versors[i].d, 0);
    }
  }
}

// Of a user's pair nothing is proved; what lies beyond the escape radius needs no proof.
TYPED_TEST(CrossMaps, ofAUsersPairOnlyWhatLiesBeyondTheRadiusIsDecided) {
  using Real = TypeParam;
  const OrbitOptions orbit{.maxIterations = 4, .escapeRadius = 3};
  const auto evaluator =
      crossEvaluator<Real>({.pair = CrossPair::User, .f = "1, 1, 1", .g = "cos(x), cos(y), cos(z)"}, orbit);
  const std::vector<Point> centres{{0, 0, 0}, {0, 2.5, 0}, {0, 2.5, 2.5}, {-3, 3, 3}, {3.49, 0, 0}, {3.51, 0, 0}};
  std::vector<julia::Decision> decisions(centres.size());
  evaluator->decide(centres, 0.5, decisions);
  for (std::size_t i = 0; i < centres.size(); ++i)
    EXPECT_EQ(decisions[i], i == 2 || i == 3 || i == 5 ? julia::Decision::Outside : julia::Decision::Undecided)
        << text(centres[i]);
  EXPECT_EQ(evaluator->dimension(), 3);
}

// The reduction by whole turns, through pair B: far arguments are as right as near ones.
TYPED_TEST(CrossMaps, cosinesOfFarPointsAreRight) {
  using Real = TypeParam;
  for (const double far : {10., 1e3, 1e6, 5e8}) {
    const std::vector<Point> points = pointsInBox(67, 500, far);
    QuaternionBatch<Real> product;
    CrossMap<Real>({.pair = CrossPair::B}).direction(batchOf<Real>(points), product);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Long wanted = std::cos(static_cast<Long>(points[i][2])) - std::cos(static_cast<Long>(points[i][1]));
      EXPECT_NEAR(product.a[i], wanted, 8 * static_cast<double>(std::numeric_limits<Real>::epsilon()))
          << text(points[i]);
    }
  }
}

// -------------------------------------------------------------------------------------------------------- bad input

TEST(CrossMapInput, isRefused) {
  EXPECT_THROW(crossEvaluator<float>({}, {.maxIterations = 0}), std::invalid_argument);
  EXPECT_THROW(crossEvaluator<float>({}, {.escapeRadius = 0}), std::invalid_argument);
  EXPECT_THROW(crossEvaluator<float>({}, {.escapeRadius = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(CrossMap<double>({.constant = {0, std::nan(""), 0}}), std::invalid_argument);
  EXPECT_THROW(CrossMap<double>({.constant = {0, 0, 1e300}}), std::invalid_argument);
  EXPECT_THROW(CrossMap<double>({.pair = CrossPair::User}), std::invalid_argument);
  const auto map = std::make_shared<CrossMap<float>>(CrossOptions{});
  EXPECT_THROW(julia::makeFieldEvaluator<float>(map, {.slice = 0.5}, {}), std::invalid_argument);
  EXPECT_THROW(julia::makeFieldEvaluator<float>(map, {.dropped = julia::DropAxis::I}, {}), std::invalid_argument);
}

}  // namespace
