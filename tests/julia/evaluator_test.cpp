// SPDX-License-Identifier: Apache-2.0
// Orbits and fields of the scalar evaluator: against the reference in 128 bits, and where the answer is known.
#include "julia/evaluator.h"

#include "julia/quadratic_map.h"
#include "julia/rational_map.h"
#include "julia/scalar_field.h"
#include "julia/shape_modulus.h"
#include "julia/shell.h"
#include "support/float128.h"
#include "support/reference.h"
#include "support/rounding_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

namespace {

namespace reference = julia::reference;
using julia::DropAxis;
using julia::Embedding;
using julia::FieldEvaluator;
using julia::makeFieldEvaluator;
using julia::Map;
using julia::OrbitOptions;
using julia::Point;
using julia::QuadraticMap;
using julia::Quaternion;
using julia::Rational;
using julia::RationalMap;
using julia::ShapeModulus;
using law_tests::BoundedOrbit;
using law_tests::floatExact;
using law_tests::kEpsilon;
using law_tests::Random;
using law_tests::StepBound;
using law_tests::text;
using law_tests::Wide;

struct Field {
  std::vector<double> value;
  std::vector<int> iterations;
};

Field evaluate(const FieldEvaluator& evaluator, const std::vector<Point>& points) {
  Field field{std::vector<double>(points.size(), std::nan("")), std::vector<int>(points.size(), -1)};
  evaluator.evaluate(points, field.value, field.iterations);
  return field;
}

template <class Real, template <class> class MapOf, class... Arguments>
std::unique_ptr<FieldEvaluator> evaluatorOf(const OrbitOptions& options, const Embedding& embedding,
                                            const Arguments&... arguments) {
  return makeFieldEvaluator<Real>(std::make_shared<MapOf<Real>>(arguments...), embedding, options);
}

/// The target of the tests: a ball of radius 3/8 with lumps (none if their height is 0). E = alpha (phi - beta) with
/// phi = |x| - 3/8 - height sin 8x sin 8y sin 8z. All numbers are exact in float.
struct Lumpy {
  double alpha = 40, height = 0, beta = 0;
  static constexpr double kRadius = 0.375, kFrequency = 8;

  template <class T>
  T exponent(const T& x, const T& y, const T& z) const {
    using std::sin;
    using std::sqrt;
    const T k = T(kFrequency);
    const T phi =
        sqrt(T(x * x + y * y + z * z)) - T(kRadius) - T(height) * T(sin(T(k * x)) * sin(T(k * y)) * sin(T(k * z)));
    return T(alpha) * (phi - T(beta));
  }
  /// The gradient of a product of three sines is at most the frequency long.
  double slope() const { return alpha * (1 + height * kFrequency); }
  /// About four roundings of each of the terms, and the sines' arguments.
  double rounding(double eps, double distance) const {
    return alpha * eps * (4 * (distance + kRadius + height + std::abs(beta)) + 2 * height * kFrequency * distance);
  }
  julia::RadialMaximum radialMaximum() const {
    julia::RadialMaximum result{1. / 64, {}};
    for (int k = 1; k <= 96; ++k) result.maximum.push_back(alpha * (result.step * k - kRadius + height - beta));
    return result;
  }
};

template <class Real>
class LumpyField final : public julia::ScalarField<Real> {
 public:
  explicit LumpyField(const Lumpy& lumpy) : mLumpy(lumpy) {}
  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = mLumpy.exponent(x[i], y[i], z[i]);
  }

 private:
  Lumpy mLumpy;
};

template <class Real>
std::unique_ptr<FieldEvaluator> shapeEvaluator(const Lumpy& lumpy, const Rational& versor, const OrbitOptions& options,
                                               const Embedding& embedding = {}) {
  return makeFieldEvaluator<Real>(
      std::make_shared<ShapeModulus<Real>>(std::make_shared<LumpyField<Real>>(lumpy), versor, embedding.dropped),
      embedding, options);
}

reference::MapFunction<Wide> shapeReference(const Lumpy& lumpy, const Rational& versor,
                                            DropAxis dropped = DropAxis::K) {
  return reference::shapeModulus<Wide>(
      [=](const Quaternion<Wide>& q) {
        switch (dropped) {
          case DropAxis::I: return lumpy.exponent<Wide>(q.a, q.c, q.d);
          case DropAxis::J: return lumpy.exponent<Wide>(q.a, q.b, q.d);
          case DropAxis::K: break;
        }
        return lumpy.exponent<Wide>(q.a, q.b, q.c);
      },
      versor);
}

/// Ten roots in the shape with powers up to 13, as an artist's run has them.
Rational tenRoots(std::uint64_t seed, bool integerPowers) {
  Random random(seed);
  Rational rational;
  for (int i = 0; i < 10; ++i) {
    Quaternion<double> t = floatExact(random.inBall() * 0.5);
    t.d = 0;
    rational.top.roots.push_back({t, integerPowers ? random.integer(2, 13) : random.between(2, 13)});
  }
  return rational;
}

/// An n^3 grid about the origin; @a spacing is to be a few bits long, so that coordinates are exact in float.
std::vector<Point> grid(int n, double spacing) {
  std::vector<Point> points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        points.push_back({(i - (n - 1) / 2.) * spacing, (j - (n - 1) / 2.) * spacing, (k - (n - 1) / 2.) * spacing});
  return points;
}

std::vector<Point> randomPointsInBox(Random& random, int count, double halfWidth) {
  std::vector<Point> points;
  const auto coordinate = [&] {
    return static_cast<double>(static_cast<float>(random.between(-halfWidth, halfWidth)));
  };
  for (int i = 0; i < count; ++i) points.push_back({coordinate(), coordinate(), coordinate()});
  return points;
}

// ------------------------------------------------------------------------------------------ against the reference

template <class Real>
class OrbitLaws : public testing::Test {
 protected:
  static constexpr double eps = kEpsilon<Real>;

  /// Signs, values and step counts are the reference's, up to the running error bound of rounding_bounds.h.
  /// @a leastJudged is the share of nodes whose sign that bound must leave no doubt of, or the law is empty.
  void expectAgrees(const FieldEvaluator& evaluator, const reference::MapFunction<Wide>& map, const StepBound& bound,
                    const std::vector<Point>& points, const OrbitOptions& options, double level, double leastJudged,
                    const std::string& what, const Embedding& embedding = {}) {
    const Field field = evaluate(evaluator, points);
    int judged = 0, iterated = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const BoundedOrbit expected = law_tests::boundedOrbit<Real>(map, bound, embedding.quaternion<Wide>(points[i]),
                                                                  options.maxIterations, options.escapeRadius);
      if (!expected.decided) continue;
      EXPECT_EQ(field.iterations[i], expected.orbit.iterations) << what << " at " << text(points[i]);
      if (expected.orbit.iterations > 1) ++iterated;
      const double wanted = static_cast<double>(expected.orbit.logModulus - Wide(level));
      if (wanted == -law_tests::kUnbounded) continue;
      // The level and the last difference are rounded too.
      const double allowed = expected.bound + 2 * eps * (std::abs(level) + std::abs(wanted));
      EXPECT_LE(std::abs(field.value[i] - wanted), allowed) << what << " at " << text(points[i]) << " for " << wanted;
      if (std::abs(wanted) <= allowed) continue;
      ++judged;
      EXPECT_EQ(field.value[i] < 0, wanted < 0)
          << what << " at " << text(points[i]) << ": " << field.value[i] << " for " << wanted;
    }
    const double share = static_cast<double>(judged) / static_cast<double>(points.size());
    this->RecordProperty("judged_" + what, std::to_string(share));
    EXPECT_GE(share, leastJudged) << what;
    EXPECT_GT(iterated, 0) << what;
  }
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(OrbitLaws, Reals);

// Promise: "Tests compare everything fast ..."
TYPED_TEST(OrbitLaws, quadratic) {
  using Real = TypeParam;
  const OrbitOptions options{.maxIterations = 7, .escapeRadius = 20};
  int number = 0;
  for (const Quaternion<double>& c :
       {Quaternion<double>{-1, 0.25, 0, 0}, {-0.125, 0.75, 0.125, 0}, {0.25, 0, 0, 0.5}}) {
    const Embedding embedding{.slice = 0.125, .dropped = std::array{DropAxis::K, DropAxis::J, DropAxis::I}[number]};
    this->expectAgrees(*evaluatorOf<Real, QuadraticMap>(options, embedding, c), reference::quadraticMap<Wide>(c),
                       law_tests::quadraticStepBound<Real>(c), grid(20, 0.171875), options, std::log(20), 0.95,
                       "c" + std::to_string(number++), embedding);
  }
}

// Promise: "Tests compare everything fast ..."
TYPED_TEST(OrbitLaws, rational) {
  using Real = TypeParam;
  const OrbitOptions options{.maxIterations = 3, .escapeRadius = 20};
  Rational rational = tenRoots(50, false);
  rational.bottom = tenRoots(51, true).top;
  rational.bottom.powerScale = 0.5;
  rational.logScale = 30;
  const Embedding embedding{.slice = 0.0625};
  this->expectAgrees(*evaluatorOf<Real, RationalMap>(options, embedding, rational),
                     reference::rationalMap<Wide>(rational), law_tests::rationalBound<Real>(rational),
                     grid(14, 0.109375), options, 0, 0.9, "rational", embedding);
}

// Promise of design.md: "Tests compare everything fast with" the reference
TYPED_TEST(OrbitLaws, shapeModulus) {
  using Real = TypeParam;
  const OrbitOptions options{.maxIterations = 3, .escapeRadius = 20};
  for (const double height : {0., 0.0625})
    for (const bool integers : {false, true}) {
      const Lumpy lumpy{.alpha = 40, .height = height, .beta = 0.015625};
      const Rational versor = tenRoots(52, integers);
      this->expectAgrees(*shapeEvaluator<Real>(lumpy, versor, options), shapeReference(lumpy, versor),
                         law_tests::shapeModulusBound<Real>(
                             versor, lumpy.slope(), [=](double r) { return lumpy.rounding(kEpsilon<Real>, r); }),
                         grid(14, 0.0859375), options, 0, 0.9,
                         (height == 0 ? std::string("sphere_") : "lumpy_") + (integers ? "integer" : "real"));
    }
}

TYPED_TEST(OrbitLaws, shapeModulusInASlice) {
  using Real = TypeParam;
  const OrbitOptions options{.maxIterations = 2, .escapeRadius = 20};
  const Lumpy lumpy{.alpha = 16, .height = 0.0625};
  const Rational versor = tenRoots(53, true);
  for (const DropAxis axis : {DropAxis::I, DropAxis::J, DropAxis::K}) {
    const Embedding embedding{.slice = -0.1875, .dropped = axis};
    this->expectAgrees(*shapeEvaluator<Real>(lumpy, versor, options, embedding), shapeReference(lumpy, versor, axis),
                       law_tests::shapeModulusBound<Real>(versor, lumpy.slope(),
                                                          [=](double r) { return lumpy.rounding(kEpsilon<Real>, r); }),
                       grid(10, 0.109375), options, 0, 0.9, "axis" + std::to_string(static_cast<int>(axis)), embedding);
  }
}

// The double evaluator is held to the reference above; a million nodes in 128 bits would take minutes.
// Promise: Floats and doubles give the same ...
TEST(FloatOrbit, flipsFewSigns) {
  const OrbitOptions options{.maxIterations = 3, .escapeRadius = 20};
  const std::vector<Point> points = grid(100, 1. / 64);
  for (const double alpha : {8., 40.})
    for (const bool integers : {false, true}) {
      const Lumpy lumpy{.alpha = alpha, .height = 0.0625};
      const Rational versor = tenRoots(54, integers);
      const Field inFloat = evaluate(*shapeEvaluator<float>(lumpy, versor, options), points);
      const Field inDouble = evaluate(*shapeEvaluator<double>(lumpy, versor, options), points);
      int flips = 0, inside = 0, iterated = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        if ((inFloat.value[i] < 0) != (inDouble.value[i] < 0)) ++flips;
        if (inDouble.value[i] < 0) ++inside;
        if (inDouble.iterations[i] > 1) ++iterated;
      }
      const std::string what = std::to_string(static_cast<int>(alpha)) + (integers ? "_integer" : "_real");
      RecordProperty("flips_" + what, flips);
      RecordProperty("inside_" + what, inside);
      RecordProperty("iterated_" + what, iterated);
      EXPECT_LT(flips, 10) << "per million, alpha " << what;
      // Enough of the nodes are in the shell, and on both sides of the surface.
      EXPECT_GT(iterated, 50'000) << what;
      EXPECT_GT(inside, 10'000) << what;
    }
}

// --------------------------------------------------------------------------------------------------- known answers

TYPED_TEST(OrbitLaws, squaringIsTheUnitBall) {
  using Real = TypeParam;
  Random random(55);
  std::vector<Point> points = randomPointsInBox(random, 2000, 1.5);
  // Close to the sphere too. Rounding moves l by a few eps a step, and each step doubles what was there: in terms of
  // ln|x| that is at most (4 + 13 + 13/2 + ...) eps.
  const double closest = 32 * this->eps;
  for (int i = 0; i < 2000; ++i) {
    const Quaternion<double> u = random.direction();
    const double shrink = (1 + random.between(-1, 1) * 64 * closest) / std::hypot(u.a, u.b, u.c);
    points.push_back(Point{static_cast<double>(static_cast<Real>(u.a * shrink)),
                           static_cast<double>(static_cast<Real>(u.b * shrink)),
                           static_cast<double>(static_cast<Real>(u.c * shrink))});
  }
  const Rational square{0, {{{{}, 2}}}, {}};
  for (const int n : {1, 2, 3, 10, 300}) {
    const auto evaluator = evaluatorOf<Real, RationalMap>({.maxIterations = n}, Embedding{}, square);
    const Field field = evaluate(*evaluator, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Wide l = log(law_tests::length(Quaternion<double>{points[i][0], points[i][1], points[i][2], 0}));
      if (abs(l) <= closest) continue;
      ASSERT_EQ(field.value[i] < 0, l < 0) << n << ' ' << text(points[i]) << ' ' << field.value[i];
    }
    // On the axes nothing is rounded: |x| = 1 is outside, and stays where it is.
    for (const Point& x : {Point{1, 0, 0}, {0, -1, 0}, {0, 0, 1}}) {
      const Field unit = evaluate(*evaluator, {x});
      EXPECT_EQ(unit.value[0], 0) << n << text(x);
      EXPECT_EQ(unit.iterations[0], n) << text(x);
    }
  }
}

TYPED_TEST(OrbitLaws, quadraticWithoutConstantIsABall) {
  using Real = TypeParam;
  Random random(56);
  for (const double escape : {4., 20.})
    for (const int n : {1, 2, 5}) {
      const double radius = std::pow(escape, std::pow(0.5, n));
      const auto evaluator = evaluatorOf<Real, QuadraticMap>({.maxIterations = n, .escapeRadius = escape}, Embedding{},
                                                             Quaternion<double>{});
      const std::vector<Point> points = randomPointsInBox(random, 2000, 1.2 * radius);
      const Field field = evaluate(*evaluator, points);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double l = std::log(std::hypot(points[i][0], points[i][1], points[i][2]));
        // An l of step i is wrong by (4 + 2 |l|) eps and a q by about three times that, doubled in each later step.
        const double allowed = 32 * this->eps * std::exp2(n) * (1 + std::abs(l));
        double value = l;
        int steps = 0;
        while (value < std::log(escape) && steps < n) value *= 2, ++steps;
        if (std::abs(value - std::log(escape)) < allowed || std::abs(value / 2 - std::log(escape)) < allowed) continue;
        ASSERT_EQ(field.value[i] < 0, std::exp(l) < radius) << n << ' ' << text(points[i]);
        ASSERT_NEAR(field.value[i], value - std::log(escape), allowed) << n << ' ' << text(points[i]);
        ASSERT_EQ(field.iterations[i], steps) << n << ' ' << text(points[i]);
      }
    }
}

TYPED_TEST(OrbitLaws, escapedAtTheStart) {
  using Real = TypeParam;
  const std::vector<Point> points = {{20, 0, 0}, {0, -30, 40}, {1e8, 0, 0}, {1e20, 1e20, 0}, {1e37, 0, -1e37}};
  const auto expectStart = [&](const FieldEvaluator& evaluator, double level, const char* what) {
    const Field field = evaluate(evaluator, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double l = std::log(std::hypot(points[i][0], points[i][1], points[i][2]));
      EXPECT_EQ(field.iterations[i], 0) << what << text(points[i]);
      EXPECT_NEAR(field.value[i], l - level, this->eps * (3 * l + 8)) << what << text(points[i]);
      EXPECT_GE(field.value[i], 0) << what << text(points[i]);
    }
  };
  const Rational versor = tenRoots(57, true);
  expectStart(*evaluatorOf<Real, QuadraticMap>({}, Embedding{}, Quaternion<double>{-1, 0, 0, 0}), std::log(20),
              "quadratic");
  expectStart(*evaluatorOf<Real, RationalMap>({}, Embedding{}, versor), 0, "rational");
  expectStart(*shapeEvaluator<Real>({}, versor, {}), 0, "shape modulus");
}

TYPED_TEST(OrbitLaws, firstStepIsTheExponent) {
  using Real = TypeParam;
  Random random(58);
  const Lumpy lumpy{.alpha = 16, .height = 0.0625};
  const std::vector<Point> points = randomPointsInBox(random, 200, 0.7);
  for (const DropAxis axis : {DropAxis::I, DropAxis::J, DropAxis::K})
    for (const double slice : {0., 0.5}) {
      const Field field = evaluate(
          *shapeEvaluator<Real>(lumpy, tenRoots(59, false), {.maxIterations = 1}, {.slice = slice, .dropped = axis}),
          points);
      for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(field.value[i],
                  static_cast<double>(lumpy.exponent(static_cast<Real>(points[i][0]), static_cast<Real>(points[i][1]),
                                                     static_cast<Real>(points[i][2]))))
            << text(points[i]) << slice;
    }
}

TEST(Embedding, slicesAlongTheDroppedAxis) {
  const Point x{1, 2, 3};
  EXPECT_EQ((Embedding{7, DropAxis::K}.quaternion<double>(x)), (Quaternion<double>{1, 2, 3, 7}));
  EXPECT_EQ((Embedding{7, DropAxis::J}.quaternion<double>(x)), (Quaternion<double>{1, 2, 7, 3}));
  EXPECT_EQ((Embedding{7, DropAxis::I}.quaternion<double>(x)), (Quaternion<double>{1, 7, 2, 3}));
  // A rational of one step is its own value at the embedded point.
  const Rational rational = tenRoots(60, false);
  const julia::RationalEvaluator<double> value(rational);
  for (const DropAxis axis : {DropAxis::I, DropAxis::J, DropAxis::K}) {
    const Embedding embedding{0.3, axis};
    const auto evaluator = evaluatorOf<double, RationalMap>({.maxIterations = 1}, embedding, rational);
    const std::vector<Point> points = {{0.1, 0.2, -0.4}};
    julia::QuaternionBatch<double> q, u;
    q.resize(1);
    q.set(0, embedding.quaternion<double>(points[0]));
    std::vector<double> l(1);
    value.logModulus(q, l);
    value.versor(q, u);
    EXPECT_EQ(evaluate(*evaluator, points).value[0], l[0]);
    Quaternion<double> versor;
    evaluator->versors(points, {&versor, 1});
    EXPECT_EQ(versor, u.get(0));
  }
}

TYPED_TEST(OrbitLaws, versorsAreThoseOfTheFirstStep) {
  using Real = TypeParam;
  Random random(61);
  const std::vector<Point> points = randomPointsInBox(random, 100, 0.8);
  std::vector<Quaternion<double>> versors(points.size());
  const Rational rational = tenRoots(62, false);
  shapeEvaluator<Real>({}, rational, {})->versors(points, versors);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Quaternion<Wide> q = Embedding{}.quaternion<Wide>(points[i]);
    const Quaternion<Wide> value = reference::evaluate<Wide>(rational.top, q);
    EXPECT_LE(law_tests::distance(versors[i], value * Wide(1 / law_tests::length(value))),
              law_tests::tolerance<Real>(rational, q.as<double>()).versor)
        << text(points[i]);
  }
}

// ------------------------------------------------------------------------------------------------ what always holds

TYPED_TEST(OrbitLaws, aPointKnowsNothingOfItsBatch) {
  using Real = TypeParam;
  Random random(63);
  const Rational rational = tenRoots(64, false);
  const std::vector<std::unique_ptr<FieldEvaluator>> evaluators = [&] {
    std::vector<std::unique_ptr<FieldEvaluator>> all;
    all.push_back(
        evaluatorOf<Real, QuadraticMap>({.maxIterations = 6}, Embedding{0.1}, Quaternion<double>{-1, 0.2, 0, 0}));
    all.push_back(evaluatorOf<Real, RationalMap>({}, Embedding{}, Rational{20, rational.top, {}}));
    all.push_back(shapeEvaluator<Real>({.alpha = 16, .height = 0.0625}, rational, {}));
    return all;
  }();
  for (const auto& evaluator : evaluators) {
    EXPECT_TRUE(evaluate(*evaluator, {}).value.empty());
    const std::vector<Point> points = randomPointsInBox(random, 500, 1);
    const Field together = evaluate(*evaluator, points);
    const Field backwards = evaluate(*evaluator, {points.rbegin(), points.rend()});
    std::vector<double> withoutIterations(points.size());
    evaluator->evaluate(points, withoutIterations, {});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Field alone = evaluate(*evaluator, {points[i]});
      EXPECT_EQ(alone.value[0], together.value[i]) << text(points[i]);
      EXPECT_EQ(alone.iterations[0], together.iterations[i]) << text(points[i]);
      EXPECT_EQ(backwards.value[points.size() - 1 - i], together.value[i]) << text(points[i]);
      EXPECT_EQ(backwards.iterations[points.size() - 1 - i], together.iterations[i]) << text(points[i]);
      EXPECT_EQ(withoutIterations[i], together.value[i]) << text(points[i]);
    }
  }
}

TYPED_TEST(OrbitLaws, fieldIsClamped) {
  using Real = TypeParam;
  // On a top root l is -inf, inside for good; on a bottom root +inf, escaped.
  const Rational rational{0, {{{{0.5, 0, 0, 0}, 2}}}, {{{{-0.5, 0, 0, 0}, 2}}}};
  const auto evaluator = evaluatorOf<Real, RationalMap>({.maxIterations = 1}, Embedding{}, rational);
  const Field field = evaluate(*evaluator, {{0.5, 0, 0}, {-0.5, 0, 0}});
  EXPECT_EQ(field.value[0], -julia::kFieldLimit);
  EXPECT_EQ(field.value[1], julia::kFieldLimit);
  const Field zero = evaluate(
      *evaluatorOf<Real, RationalMap>({.maxIterations = 5}, Embedding{}, Rational{0, {{{{}, 2}}}, {}}), {{0, 0, 0}});
  EXPECT_EQ(zero.value[0], -julia::kFieldLimit);
  EXPECT_EQ(zero.iterations[0], 5);
}

// An iterate of 0 is a point like any other: only a trap may end its orbit.
TYPED_TEST(OrbitLaws, zeroGoesOn) {
  using Real = TypeParam;
  // i -> i^2 + 1 = 0 -> 1 -> 2 -> 5 -> 26
  const std::vector<Point> points = {{0, 1, 0}};
  const Field quadratic = evaluate(
      *evaluatorOf<Real, QuadraticMap>({.maxIterations = 9}, Embedding{}, Quaternion<double>{1, 0, 0, 0}), points);
  EXPECT_EQ(quadratic.iterations[0], 5);
  EXPECT_NEAR(quadratic.value[0], std::log(26 / 20.), 16 * this->eps);
  // i -> (i - i) (i - 64 j) = 0 -> (-i) (-64 j), of length 64.
  const Rational rational{0, {{{{0, 1, 0, 0}, 1}, {{0, 0, 64, 0}, 1}}}, {}};
  const Field outside = evaluate(*evaluatorOf<Real, RationalMap>({.maxIterations = 9}, Embedding{}, rational), points);
  EXPECT_EQ(outside.iterations[0], 2);
  EXPECT_NEAR(outside.value[0], std::log(64), 16 * this->eps);
  // With a trap it is inside.
  const Field trapped =
      evaluate(*evaluatorOf<Real, RationalMap>({.maxIterations = 9, .logTrap = -5}, Embedding{}, rational), points);
  EXPECT_EQ(trapped.iterations[0], 1);
  EXPECT_EQ(trapped.value[0], -julia::kFieldLimit);
}

template <class Real>
class ConstantField final : public julia::ScalarField<Real> {
 public:
  explicit ConstantField(double value) : mValue(static_cast<Real>(value)) {}
  void sample(std::span<const Real>, std::span<const Real>, std::span<const Real>, std::span<Real> out) const override {
    std::fill(out.begin(), out.end(), mValue);
  }

 private:
  Real mValue;
};

// Promise: Nothing that is written is infinite ...
TYPED_TEST(OrbitLaws, nothingInfiniteOrNaNLeaves) {
  using Real = TypeParam;
  Random random(65);
  const std::vector<double> numbers = {0,    -0., 1e-320, 1e-45, 1e-38, -1e-30, 1e-19, 1e-8,  0.5,    -1,   1,
                                       19.9, 20,  -1e9,   1e9,   1e19,  -1e30,  3e38,  1e200, -1e308, 0.25, -0.5};
  const std::vector<double> powers = {0.5, -0.5, 1, 2, -3, 13.25, 50, -50, 1e5, 1e9, -1e9};
  const auto pick = [&random](const std::vector<double>& from) {
    return from[static_cast<std::size_t>(random.integer(0, static_cast<int>(from.size()) - 1))];
  };
  const auto within = [&](double limit) {
    for (;;)
      if (const double x = pick(numbers); std::abs(x) <= limit) return x;
  };
  for (int round = 0; round < 1500; ++round) {
    Rational rational{within(1e9), {}, {}};
    for (auto* polynomial : {&rational.top, &rational.bottom})
      for (int i = random.integer(0, 4); i > 0; --i)
        polynomial->roots.push_back({{within(1e9), within(1e9), within(1e9), within(1)}, pick(powers)});
    std::vector<Point> points;
    for (int i = 0; i < 20; ++i) points.push_back({pick(numbers), pick(numbers), pick(numbers)});
    for (const auto& root : rational.top.roots) points.push_back({root.position.a, root.position.b, root.position.c});
    const Embedding embedding{within(1e9), std::array{DropAxis::I, DropAxis::J, DropAxis::K}[random.integer(0, 2)]};
    const OrbitOptions options{
        .maxIterations = random.integer(1, 12),
        .escapeRadius = std::array{1.0001, 20., 1e9}[random.integer(0, 2)],
        .logTrap = std::array{-std::numeric_limits<double>::infinity(), -3., -1e300}[random.integer(0, 2)]};
    const Quaternion<double> c{within(1e30), within(1e30), within(1e30), within(1e30)};
    const std::array<std::unique_ptr<FieldEvaluator>, 3> evaluators = {
        evaluatorOf<Real, RationalMap>(options, embedding, rational),
        evaluatorOf<Real, QuadraticMap>(options, embedding, c),
        makeFieldEvaluator<Real>(std::make_shared<ShapeModulus<Real>>(
                                     std::make_shared<ConstantField<Real>>(within(1e30)), rational, embedding.dropped),
                                 embedding, options)};
    for (std::size_t which = 0; which < evaluators.size(); ++which) {
      const Field field = evaluate(*evaluators[which], points);
      std::vector<Quaternion<double>> versors(points.size());
      evaluators[which]->versors(points, versors);
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_TRUE(std::abs(field.value[i]) <= julia::kFieldLimit)
            << field.value[i] << ", map " << which << ", round " << round << " at " << text(points[i]) << ": "
            << law_tests::text(rational) << " c = " << text(c);
        ASSERT_TRUE(field.iterations[i] >= 0 && field.iterations[i] <= options.maxIterations) << round;
        // Where the map itself overflows Real the versor is anybody's guess, but no NaN.
        ASSERT_LE(abs(law_tests::length(versors[i]) - 1), 4 * this->eps)
            << "map " << which << ", round " << round << " at " << text(points[i]) << ": " << law_tests::text(rational)
            << " c = " << text(c);
      }
    }
  }
}

TEST(Evaluator, refusesImpossibleOptions) {
  const auto make = [](const OrbitOptions& options, double slice) {
    return evaluatorOf<double, QuadraticMap>(options, Embedding{slice}, Quaternion<double>{});
  };
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  EXPECT_NO_THROW(make({}, 0));
  EXPECT_NO_THROW(make({.maxIterations = julia::kMaxIterations, .escapeRadius = julia::kMaxEscapeRadius}, -1e9));
  for (const int n : {0, -1, julia::kMaxIterations + 1})
    EXPECT_THROW(make({.maxIterations = n}, 0), std::invalid_argument) << n;
  for (const double escape : {1., 0., -20., 1.0001e9, nan, infinity})
    EXPECT_THROW(make({.escapeRadius = escape}, 0), std::invalid_argument) << escape;
  for (const double slice : {nan, infinity, -infinity, 2e9})
    EXPECT_THROW(make({}, slice), std::invalid_argument) << slice;
  EXPECT_THROW(make({.logTrap = nan}, 0), std::invalid_argument);
}

// Promise: "E may be clamped to the interval ..."
TYPED_TEST(OrbitLaws, trapKeepsEverySign) {
  using Real = TypeParam;
  for (const double alpha : {10., 40., 100.})
    for (const double height : {0., 0.03125}) {
      const Lumpy lumpy{.alpha = alpha, .height = height};
      const OrbitOptions free{.maxIterations = 4, .escapeRadius = 20};
      const julia::ShellInterval shell = shellInterval(lumpy.radialMaximum(), free.maxIterations, free.escapeRadius);
      ASSERT_GT(shell.lower, -std::numeric_limits<double>::infinity()) << alpha << ' ' << height;
      OrbitOptions trapped = free;
      trapped.logTrap = shell.lower;
      const Rational versor = tenRoots(67, false);
      const std::vector<Point> points = grid(40, 1. / 64);
      const Field without = evaluate(*shapeEvaluator<Real>(lumpy, versor, free), points);
      const Field with = evaluate(*shapeEvaluator<Real>(lumpy, versor, trapped), points);
      // To confirm the trap changes no value that an orbit gives.
      OrbitOptions confirmed = trapped;
      confirmed.confirmTrap = true;
      std::vector<double> nearest(points.size()), nearestConfirmed(points.size());
      shapeEvaluator<Real>(lumpy, versor, trapped)->orbitTraps(points, nearest);
      shapeEvaluator<Real>(lumpy, versor, confirmed)->orbitTraps(points, nearestConfirmed);
      EXPECT_EQ(nearest, nearestConfirmed) << alpha << ' ' << height;
      EXPECT_EQ(with.value, evaluate(*shapeEvaluator<Real>(lumpy, versor, confirmed), points).value);
      int saved = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(with.value[i] < 0, without.value[i] < 0) << alpha << ' ' << height << text(points[i]);
        ASSERT_LE(with.iterations[i], without.iterations[i]) << text(points[i]);
        saved += without.iterations[i] - with.iterations[i];
        // Both ends of the interval decide by the first step alone, which is E.
        const double E = lumpy.exponent(points[i][0], points[i][1], points[i][2]);
        const double margin = lumpy.rounding(this->eps, 2);
        if (E <= shell.lower - margin || E >= shell.upper + margin) {
          ASSERT_EQ(without.value[i] < 0, E < 0) << alpha << ' ' << height << text(points[i]);
        }
      }
      EXPECT_GT(saved, 0) << alpha << ' ' << height;
    }
}

}  // namespace
