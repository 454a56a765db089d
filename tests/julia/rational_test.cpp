// SPDX-License-Identifier: Apache-2.0
// Laws of quaternion rationals, and their log-polar evaluation in float and double against Cartesian 128 bits.
#include "julia/rational.h"

#include "support/float128.h"
#include "support/limits.h"
#include "support/reference.h"
#include "support/rounding_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace {

using julia::Polynomial;
using julia::Quaternion;
using julia::Rational;
using julia::Root;
using law_tests::distance;
using law_tests::floatExact;
using law_tests::kEpsilon;
using law_tests::length;
using law_tests::Random;
using law_tests::text;
using law_tests::Tolerance;
using law_tests::tolerance;
using law_tests::Wide;
using test_limits::kInfinity;

/// Gives both results at a point.
template <class Real>
struct RationalEvaluator : julia::RationalEvaluator<Real> {
  struct Value {
    Real l;
    Quaternion<Real> u;
  };
  using julia::RationalEvaluator<Real>::RationalEvaluator;
  Value operator()(const Quaternion<Real>& q) const { return {this->logModulus(q), this->versor(q)}; }
};

template <class Real>
class RationalLaws : public testing::Test {
 protected:
  static constexpr double eps = kEpsilon<Real>;
  static constexpr double kUnit = 4 * eps;  ///< how far a normalised versor's length may be from 1

  static void expectAgrees(const Rational& rational, const Quaternion<double>& q, const std::string& what) {
    const auto value = RationalEvaluator<Real>(rational)(q.template as<Real>());
    const std::optional<Quaternion<Wide>> expected = julia::reference::evaluate<Wide>(rational, q.as<Wide>(), false);
    ASSERT_TRUE(expected.has_value());
    const Wide size = length(*expected);
    // Otherwise the test would be the one to overflow.
    ASSERT_TRUE(size > 0 && size <= std::numeric_limits<Wide>::max()) << what << text(rational);
    const Tolerance allowed = tolerance<Real>(rational, q);
    EXPECT_LE(abs(Wide(value.l) - log(size)), allowed.l) << what << " at " << text(q) << ": " << text(rational);
    EXPECT_LE(distance(value.u, *expected * Wide(1 / size)), allowed.versor)
        << what << " at " << text(q) << ": " << text(rational);
  }
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(RationalLaws, Reals);

enum class Powers { Positive, Whole, Any };

double randomPower(Random& random, Powers powers) {
  if (powers == Powers::Positive) return random.between(0.1, 13);
  if (powers == Powers::Whole) return random.integer(-6, 13);
  // A tenth of them are 0, a third whole.
  const int kind = random.integer(0, 9);
  return kind == 0 ? 0 : kind < 4 ? random.integer(-6, 13) : random.between(-6, 13);
}

Polynomial polynomialOf(Random& random, int count, Powers powers, double radius = 1) {
  Polynomial polynomial;
  for (int i = 0; i < count; ++i)
    polynomial.roots.push_back({floatExact(random.inBall() * radius), randomPower(random, powers)});
  return polynomial;
}

// Promise: "Tests compare everything fast ..."
TYPED_TEST(RationalLaws, agreesWithTheReference) {
  Random random(10);
  for (int round = 0; round < 60; ++round) {
    const Powers powers = std::array{Powers::Positive, Powers::Whole, Powers::Any}[round % 3];
    const int roots = random.integer(1, 40);
    const int top = round % 4 == 0 ? roots : random.integer(0, roots);
    Rational rational{random.between(-5, 5), polynomialOf(random, top, powers),
                      polynomialOf(random, roots - top, powers)};
    if (round % 2 == 1) rational.top.powerScale = random.between(-1, 2), rational.bottom.powerScale = 0.375;
    for (int i = 0; i < 5; ++i)
      this->expectAgrees(rational, floatExact(random.inBall() * random.between(0.1, 20)),
                         "round " + std::to_string(round));
  }
}

// Promise: The log-polar form never ...
TYPED_TEST(RationalLaws, thousandRootsWithPowersToFifty) {
  // Roots on the unit sphere seen from near its centre: ln|q - t| is near 0, and 50 times a thousand of them stay in
  // the range of 128 bits (e^11356), though in no other's.
  Random random(11);
  for (const bool whole : {false, true}) {
    Rational rational;
    for (int i = 0; i < 1000; ++i) {
      const double power = whole ? random.integer(1, 50) : random.between(-10, 50);
      (i % 3 == 0 ? rational.bottom : rational.top).roots.push_back({floatExact(random.direction()), power});
    }
    for (int i = 0; i < 3; ++i)
      this->expectAgrees(rational, floatExact(random.inBall() * 0.3), whole ? "whole" : "real");
  }
}

TYPED_TEST(RationalLaws, closeToARoot) {
  Random random(12);
  for (const double gap : {1e-30, 1e-36, 1e-42}) {
    Rational rational{0.5, polynomialOf(random, 3, Powers::Any), polynomialOf(random, 2, Powers::Any)};
    rational.top.roots.push_back({{}, 2.5});
    for (int i = 0; i < 10; ++i) {
      const Quaternion<double> q = floatExact(random.direction() * gap);
      if (q == Quaternion<double>{}) continue;
      this->expectAgrees(rational, q, "gap " + std::to_string(std::log10(gap)));
    }
  }
  // The nearest neighbours in Real of a root that is not 0.
  using Real = TypeParam;
  const Quaternion<double> root = floatExact({0.3, -0.7, 0.1, 0});
  const Rational rational{0, {{{root, 3}, {{1, 1, 0, 0}, 0.5}}}, {{{{0, 0, 1, 0}, 1}}}};
  Quaternion<Real> q = root.as<Real>();
  q.c = std::nextafter(q.c, Real(1));
  this->expectAgrees(rational, q.template as<double>(), "next number");
}

// Promise: "The versor of 0 is 1", and "coincident ..."
TYPED_TEST(RationalLaws, rootsHitExactly) {
  using Real = TypeParam;
  const Real infinity = std::numeric_limits<Real>::infinity();
  const Quaternion<double> t{0.25, -0.5, 0, 0}, other{1, 0, 0.5, 0};
  // Assigned, because g++ 12 warns about nested temporaries of Rational.
  const auto quotient = [](const Polynomial& top, const Polynomial& bottom) {
    Rational rational;
    rational.logScale = 7;
    rational.top = top;
    rational.bottom = bottom;
    return rational;
  };
  const auto l = [&](const Rational& rational) { return RationalEvaluator<Real>(rational).logModulus(t.as<Real>()); };
  const auto versor = [&](const Rational& rational) { return RationalEvaluator<Real>(rational).versor(t.as<Real>()); };
  const Polynomial none;
  for (const double p : {0.001, 1., 2.5, 13.}) {
    EXPECT_EQ(l(quotient({{{t, p}, {other, 2}}}, none)), -infinity) << p;
    EXPECT_EQ(l(quotient(none, {{{other, 2}, {t, p}}})), infinity) << p;
    EXPECT_EQ(l(quotient({{{t, -p}}}, none)), infinity) << p;
    EXPECT_EQ(l(quotient({{{t, p}}, -1}, none)), infinity) << p;
    EXPECT_EQ(l(quotient(none, {{{t, -p}}})), -infinity) << p;
    // Unequal powers: the net one decides.
    EXPECT_EQ(l(quotient({{{t, p + 1}, {other, 2}}}, {{{t, p}}})), -infinity) << p;
    EXPECT_EQ(l(quotient({{{t, p}, {other, 2}}}, {{{t, p + 1}}})), infinity) << p;
    // Equal powers: nothing is left of the root, not even a rounding.
    const Rational cancelling = quotient({{{t, p}, {other, 2}}}, {{{t, p}}}), rest = quotient({{{other, 2}}}, none);
    EXPECT_EQ(l(cancelling), l(rest)) << p;
    EXPECT_EQ(versor(cancelling), versor(rest)) << p;
    // The versor of a factor that is 0 is 1.
    EXPECT_EQ(versor(quotient({{{t, p}, {other, 2}}}, none)), versor(rest)) << p;
  }
  EXPECT_EQ(l(quotient({{{t, 0}}}, {{{t, 0}}})), Real(7));
  EXPECT_EQ(l(quotient({{{t, 5}}, 0}, none)), Real(7));
  EXPECT_EQ(versor(quotient({{{t, 3}}}, none)), Quaternion<Real>::one());
}

TYPED_TEST(RationalLaws, orderTurnsTheVersorOnly) {
  using Real = TypeParam;
  Random random(13);
  int turned = 0;
  for (int round = 0; round < 50; ++round) {
    const Rational rational{0, polynomialOf(random, 6, Powers::Any), polynomialOf(random, 4, Powers::Any)};
    Rational permuted = rational;
    std::reverse(permuted.top.roots.begin(), permuted.top.roots.end());
    std::rotate(permuted.bottom.roots.begin(), permuted.bottom.roots.begin() + 1, permuted.bottom.roots.end());
    const Quaternion<double> q = floatExact(random.inBall() * 2.0);
    const auto value = RationalEvaluator<Real>(rational)(q.template as<Real>());
    const auto other = RationalEvaluator<Real>(permuted)(q.template as<Real>());
    EXPECT_LE(std::abs(value.l - other.l), 2 * tolerance<Real>(rational, q).l) << round << text(rational);
    if (distance(value.u, other.u) > 0.01) ++turned;
    // All roots on one line commute.
    Rational line = rational;
    for (Polynomial* polynomial : {&line.top, &line.bottom})
      for (Root& root : polynomial->roots) root.position.b = root.position.c = root.position.d = 0;
    Rational reversed = line;
    std::reverse(reversed.top.roots.begin(), reversed.top.roots.end());
    EXPECT_LE(distance(RationalEvaluator<Real>(line).versor(q.template as<Real>()),
                       RationalEvaluator<Real>(reversed).versor(q.template as<Real>())),
              2 * tolerance<Real>(line, q).versor)
        << round << text(line);
  }
  // Two random quaternions do not commute; that ten of them nearly do is a chance of percents.
  EXPECT_GE(turned, 40);
}

// Promise: "The versor of 0 is 1", and "coincident ..."
TYPED_TEST(RationalLaws, aPolynomialOverItselfIsOne) {
  using Real = TypeParam;
  Random random(14);
  for (int round = 0; round < 50; ++round) {
    const Polynomial p = polynomialOf(random, random.integer(1, 20), Powers::Any);
    const Rational one{0, p, p};
    const Quaternion<double> q = floatExact(random.inBall() * 2.0);
    const auto value = RationalEvaluator<Real>(one)(q.template as<Real>());
    const Tolerance allowed = tolerance<Real>(one, q);
    EXPECT_LE(std::abs(value.l), allowed.l) << round << text(one) << text(q);
    EXPECT_LE(distance(value.u, Quaternion<Real>::one()), allowed.versor) << round << text(one) << text(q);
  }
}

// Chiefly that nothing is NaN, whatever is close to, far from or on whatever, with powers up to the largest allowed.
// Promise: Nothing that is written is infinite ...
TYPED_TEST(RationalLaws, neverNaN) {
  using Real = TypeParam;
  using Limits = std::numeric_limits<Real>;
  Random random(15);
  const std::vector<double> rootParts = {0, -0., 1e-300, 1e-42, -1e-38, 1e-30, 1e-20, 0.5, -1, 1 + 1e-7, 20, -1e9, 1e9};
  const std::vector<double> pointParts = {
      0,    -0.,  Limits::denorm_min(), Limits::min(), -1e-30, 1e-20, 0.5, -1, 20, 1e9, -1e18,
      1e19, 1e30, Limits::max(),        1e-38};
  const std::vector<double> powers = {0,  1e-300, 1e-9, 0.5, -0.5,       1,   -1,   2.5,
                                      13, -13,    50,   1e4, 16777217.0, 1e9, -1e9, 123456789.5};
  const auto pick = [&random](const auto& from) {
    return from[static_cast<std::size_t>(random.integer(0, static_cast<int>(from.size()) - 1))];
  };
  for (int round = 0; round < 20000; ++round) {
    Rational rational{random.integer(0, 3) == 0 ? pick(std::vector{1e9, -1e9, 88., 710.}) : 0, {}, {}};
    for (Polynomial* polynomial : {&rational.top, &rational.bottom})
      for (int i = random.integer(0, 6); i > 0; --i)
        polynomial->roots.push_back(
            {{pick(rootParts), pick(rootParts), pick(rootParts), pick(rootParts)}, pick(powers)});
    const Quaternion<Real> anywhere =
        Quaternion<double>{pick(pointParts), pick(pointParts), pick(pointParts), pick(pointParts)}.template as<Real>();
    const bool onRoot = round % 3 == 0 && !rational.top.roots.empty();
    const Quaternion<Real> q = onRoot ? rational.top.roots[0].position.template as<Real>() : anywhere;
    const auto value = RationalEvaluator<Real>(rational)(q);
    ASSERT_FALSE(std::isnan(value.l)) << round << ' ' << text(q) << text(rational);
    ASSERT_LE(abs(length(value.u) - 1), this->kUnit) << round << ' ' << text(q) << text(rational);
  }
}

// Promise: The log-polar form never ...
TYPED_TEST(RationalLaws, manyLargePowersKeepAVersor) {
  using Real = TypeParam;
  Random random(16);
  for (const double power : {50., 1000., 1025., 1e6, 1e9}) {
    Rational rational;
    for (int i = 0; i < 3000; ++i) rational.top.roots.push_back({random.inBall(), power});
    const auto value = RationalEvaluator<Real>(rational)(random.inBall().template as<Real>());
    EXPECT_TRUE(std::isfinite(value.l)) << power;
    EXPECT_LE(abs(length(value.u) - 1), this->kUnit) << power;
  }
}

TYPED_TEST(RationalLaws, rootCountLeavesOutPowerZero) {
  using Real = TypeParam;
  const Rational rational{0, {{{{}, 1}, {{}, 0}, {{}, -2}}}, {{{{}, 3}}}};
  EXPECT_EQ(RationalEvaluator<Real>(rational).rootCount(), 3U);
}

TEST(Rational, summedPowers) {
  EXPECT_EQ(julia::summedPowers({}), 0);
  EXPECT_EQ(julia::summedPowers({{{{}, 2}, {{1, 0, 0, 0}, -0.5}, {{}, 0}}}), 1.5);
  EXPECT_EQ(julia::summedPowers({{{{}, 2}, {{1, 0, 0, 0}, -0.5}}, -4}), -6);
  // It is the slope of l in ln|q| far away.
  Random random(17);
  const Rational rational{1, polynomialOf(random, 9, Powers::Any), polynomialOf(random, 5, Powers::Any)};
  const RationalEvaluator<double> evaluator(rational);
  const Quaternion<double> u = random.direction();
  const double slope = (evaluator.logModulus(u * 1e16) - evaluator.logModulus(u * 1e8)) / std::log(1e8);
  EXPECT_NEAR(slope, summedPowers(rational.top) - summedPowers(rational.bottom), 1e-6);
}

// Offsets, factors and points are powers of 2 or a few bits long, so that moving rounds nothing.
TEST(Rational, translatedMovesTheValues) {
  const Rational rational{
      0.5, {{{{0.5, 0.25, -1, 0}, 2.5}, {{1, 0, 0.125, 0.5}, 3}}, 0.75}, {{{{-0.75, 0, 0.5, 0}, 1.5}}, 2}};
  const Quaternion<double> offset{2, -0.5, 0.25, 4};
  const RationalEvaluator<double> evaluator(rational), moved(julia::translated(rational, offset));
  Random random(18);
  for (int i = 0; i < 20; ++i) {
    const Quaternion<double> q = floatExact(random.inBall());
    EXPECT_EQ(moved(q + offset).l, evaluator(q).l) << text(q);
    EXPECT_EQ(moved(q + offset).u, evaluator(q).u) << text(q);
  }
  EXPECT_EQ(julia::translated(julia::translated(rational, offset), offset * -1.0), rational);
}

TEST(Rational, scaledIsHomogeneous) {
  const Rational rational{0.5, {{{{0.5, 0.25, -1, 0}, 2.5}, {{1, 0, 0.125, 0.5}, 3}}}, {{{{-0.75, 0, 0.5, 0}, 1.5}}}};
  const double degree = summedPowers(rational.top) - summedPowers(rational.bottom);
  Random random(19);
  for (const double factor : {0.125, 2., 1024.}) {
    const RationalEvaluator<double> evaluator(rational), larger(julia::scaled(rational, factor));
    for (int i = 0; i < 20; ++i) {
      const Quaternion<double> q = random.inBall();
      const Tolerance allowed = tolerance<double>(rational, q);
      const Tolerance allowedThere = tolerance<double>(julia::scaled(rational, factor), q * factor);
      EXPECT_NEAR(larger(q * factor).l, evaluator(q).l + degree * std::log(factor), allowed.l + allowedThere.l)
          << factor << text(q);
      EXPECT_LE(distance(larger(q * factor).u, evaluator(q).u), allowed.versor + allowedThere.versor)
          << factor << text(q);
    }
  }
  // -1 turns every factor about: whole powers give the sign (-1)^degree.
  Rational whole{0, {{{{0.5, 0.25, -1, 0}, 2}, {{1, 0, 0.125, 0.5}, 3}}}, {{{{-0.75, 0, 0.5, 0}, 2}}}};
  const RationalEvaluator<double> evaluator(whole), mirrored(julia::scaled(whole, -1));
  const Quaternion<double> q{0.3, 0.1, -0.2, 0.4};
  EXPECT_EQ(mirrored(q * -1.0).l, evaluator(q).l);
  EXPECT_EQ(mirrored(q * -1.0).u, evaluator(q).u * -1.0);
  for (const double bad : {0., kInfinity, -kInfinity, std::nan("")})
    EXPECT_THROW(julia::scaled(whole, bad), std::invalid_argument) << bad;
}

TEST(Rational, productOfValues) {
  Random random(20);
  for (int round = 0; round < 60; ++round) {
    Rational left{random.between(-1, 1), polynomialOf(random, random.integer(0, 5), Powers::Any), {}};
    Rational right{random.between(-1, 1), polynomialOf(random, random.integer(0, 5), Powers::Any),
                   polynomialOf(random, random.integer(0, 5), Powers::Any)};
    // In one order the left bottom must be 1: the bottoms of a product stand behind all tops.
    if (round % 2 == 1) left.bottom = polynomialOf(random, 3, Powers::Any);
    for (Polynomial* polynomial : {&left.top, &left.bottom, &right.top, &right.bottom})
      if (random.integer(0, 2) != 0) polynomial->powerScale = std::array{0., 0.5, -2., 0.3}[random.integer(0, 3)];
    const Rational both = product(left, right);
    EXPECT_NO_THROW(requireFinite(both)) << round << text(left) << " * " << text(right);
    const Quaternion<double> q = random.inBall() * 2.0;
    const auto value = RationalEvaluator<double>(both)(q);
    const auto atLeft = RationalEvaluator<double>(left)(q), atRight = RationalEvaluator<double>(right)(q);
    const Tolerance a = tolerance<double>(left, q), b = tolerance<double>(right, q), c = tolerance<double>(both, q);
    EXPECT_NEAR(value.l, (atLeft.l + atRight.l), a.l + b.l + c.l) << round << text(left) << " * " << text(right);
    if (left.bottom.roots.empty()) {
      EXPECT_LE(distance(value.u, atLeft.u * atRight.u), a.versor + b.versor + c.versor + 4 * kEpsilon<double>)
          << round << text(left) << " * " << text(right);
    }
  }
}

TEST(Rational, productKeepsACommonPowerScale) {
  const Rational left{1, {{{{1, 0, 0, 0}, 2}}, 3}, {}}, right{2, {{{{0, 1, 0, 0}, 5}}, 3}, {{{{}, 1}}, 0}};
  const Rational both = product(left, right);
  EXPECT_EQ(both.logScale, 3);
  EXPECT_EQ(both.top, (Polynomial{{{{1, 0, 0, 0}, 2}, {{0, 1, 0, 0}, 5}}, 3}));
  EXPECT_EQ(summedPowers(both.bottom), 0);
  EXPECT_EQ(summedPowers(product(right, right).bottom), 0);
}

TEST(Rational, requireFiniteNamesTheNumber) {
  const Rational good{1, {{{{1, 2, 3, 4}, 5}, {{1, 2, 3, 4}, 5}}, 2}, {{{{1, 2, 3, 4}, 5}}, 2}};
  EXPECT_NO_THROW(requireFinite(good));
  const auto expectThrow = [&](auto&& change, const std::string& name) {
    for (const double bad : {std::nan(""), kInfinity, -kInfinity, 1e10, -1e10}) {
      Rational rational = good;
      change(rational) = bad;
      try {
        requireFinite(rational);
        ADD_FAILURE() << name << " = " << bad << " was accepted";
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      }
      EXPECT_THROW(RationalEvaluator<float>{rational}, std::invalid_argument) << name << bad;
      EXPECT_THROW(RationalEvaluator<double>{rational}, std::invalid_argument) << name << bad;
    }
  };
  expectThrow([](Rational& r) -> double& { return r.logScale; }, "constant C");
  expectThrow([](Rational& r) -> double& { return r.top.powerScale; }, "power scale of the top");
  expectThrow([](Rational& r) -> double& { return r.bottom.powerScale; }, "power scale of the bottom");
  expectThrow([](Rational& r) -> double& { return r.top.roots[1].position.a; }, "component of top root 1");
  expectThrow([](Rational& r) -> double& { return r.top.roots[1].position.b; }, "component of top root 1");
  expectThrow([](Rational& r) -> double& { return r.bottom.roots[0].position.c; }, "component of bottom root 0");
  expectThrow([](Rational& r) -> double& { return r.bottom.roots[0].position.d; }, "component of bottom root 0");
  expectThrow([](Rational& r) -> double& { return r.top.roots[0].power; }, "power of top root 0");
  expectThrow([](Rational& r) -> double& { return r.bottom.roots[0].power; }, "power of bottom root 0");
  // Each is allowed, their product is not.
  Rational scaledPower = good;
  scaledPower.top.powerScale = 1e6;
  scaledPower.top.roots[1].power = 1e6;
  EXPECT_THROW(requireFinite(scaledPower), std::invalid_argument);
}

}  // namespace
