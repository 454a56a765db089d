// SPDX-License-Identifier: Apache-2.0
// The slow reference keeps its own laws; and the guard of [KD20] is needed by it, but not by the log-polar form.
#include "support/reference.h"

#include "julia/evaluator.h"
#include "julia/rational_map.h"
#include "support/float128.h"
#include "support/rounding_bounds.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

namespace {

namespace reference = julia::reference;
using julia::Quaternion;
using julia::Rational;
using law_tests::distance;
using law_tests::floatExact;
using law_tests::length;
using law_tests::Random;
using law_tests::text;
using law_tests::Wide;

// A few dozen operations on numbers of 113 bits, of which acos near +-1 keeps half.
const Wide kWideTolerance = 1e-15;

TEST(Reference, powersAreProducts) {
  Random random(30);
  for (int round = 0; round < 50; ++round) {
    const Quaternion<Wide> q = (random.inBall() * random.between(0.1, 10)).as<Wide>(), one = Quaternion<Wide>::one();
    const Wide size = length(q);
    EXPECT_LE(distance(reference::power<Wide>(q, 0), one), kWideTolerance) << text(q);
    EXPECT_LE(distance(reference::power<Wide>(q, 1), q), kWideTolerance * size) << text(q);
    EXPECT_LE(distance(reference::power<Wide>(q, 3), q * q * q), kWideTolerance * size * size * size) << text(q);
    EXPECT_LE(distance(reference::power<Wide>(q, -1) * q, one), kWideTolerance) << text(q);
    EXPECT_LE(distance(reference::power<Wide>(q, 0.5) * reference::power<Wide>(q, 0.5), q), kWideTolerance * size)
        << text(q);
    const Wide p = random.between(-3, 3), r = random.between(-3, 3);
    const Quaternion<Wide> sum = reference::power<Wide>(q, p + r);
    EXPECT_LE(distance(reference::power<Wide>(q, p) * reference::power<Wide>(q, r), sum), kWideTolerance * length(sum))
        << text(q) << ' ' << p << ' ' << r;
  }
}

TEST(Reference, powersOfZeroAndOfNegativeReals) {
  const Quaternion<double> zero, minusFour{-4, 0, 0, 0};
  EXPECT_EQ(reference::power<double>(zero, 0), Quaternion<double>::one());
  EXPECT_EQ(reference::power<double>(zero, 2.5), zero);
  EXPECT_LE(distance(reference::power<double>(minusFour, 0.5), Quaternion<double>{0, 2, 0, 0}), Wide(1e-15));
  EXPECT_LE(distance(reference::power<double>(minusFour, -1), Quaternion<double>{-0.25, 0, 0, 0}), Wide(1e-15));
}

TEST(Reference, rationalIsTopTimesInverseOfBottom) {
  const Quaternion<Wide> a{1, 2, 0, -1}, b{0, 1, 1, 0}, c{3, 0, 0.5, 1}, q{0.5, 0.25, -1, 2};
  const Rational rational{
      2, {{{a.as<double>(), 1}, {b.as<double>(), 2}}}, {{{c.as<double>(), 1}, {a.as<double>(), 1}}}};
  const std::optional<Quaternion<Wide>> value = reference::evaluate<Wide>(rational, q, false);
  ASSERT_TRUE(value.has_value());
  // f (bottom) = e^C top
  const Quaternion<Wide> top = (q - a) * (q - b) * (q - b) * Wide(exp(Wide(2)));
  EXPECT_LE(distance(*value * ((q - c) * (q - a)), top), kWideTolerance * length(top));
}

TEST(Reference, orbitStopsAtEscapeAndAtTheLastStep) {
  const auto square = reference::quadraticMap<Wide>({});
  // |q| = 2: 2, 4, 16, 256
  const Quaternion<Wide> q{0, 2, 0, 0};
  EXPECT_EQ(reference::orbit<Wide>(square, q, 10, Wide(20)).iterations, 3);
  EXPECT_EQ(reference::orbit<Wide>(square, q, 2, Wide(20)).iterations, 2);
  EXPECT_EQ(reference::orbit<Wide>(square, q, 10, Wide(2)).iterations, 0);
  EXPECT_LE(abs(reference::orbit<Wide>(square, q, 10, Wide(20)).logModulus - log(Wide(256))), kWideTolerance);
  EXPECT_EQ(reference::orbit<Wide>(square, {}, 3, Wide(20)).logModulus, -std::numeric_limits<Wide>::infinity());
}

TEST(Guard, tripsWhereEquationTwoSaysSo) {
  // |B| < 10^(308 - 1.05 (log10 |B| + sum)): with a sum of 100 that is log10 |B| < 203 / 2.05 = 99.02.
  EXPECT_FALSE(reference::guardTrips<double>(1e98, 100));
  EXPECT_FALSE(reference::guardTrips<double>(1e99, 100));
  EXPECT_TRUE(reference::guardTrips<double>(2e99, 100));
  // "the summed polynomial degrees already exceed 38, so even the first iteration will not fit" in 32 bits.
  EXPECT_TRUE(reference::guardTrips<float>(1, 89.3455F));
  EXPECT_FALSE(reference::guardTrips<double>(1, 89.3455));
  // Nothing finite trips the guard of 128 bits at that degree before it is far beyond double.
  EXPECT_FALSE(reference::guardTrips<Wide>(Wide(std::numeric_limits<double>::max()), 127.73));
}

/// A rational like the bunny of [KD20] Table 1: 178 top roots with powers that sum to 251.998, 153 bottom ones with
/// 89.3455, near a sphere of radius 4, and the C that puts the surface there.
Rational likeTheBunny() {
  Random random(31);
  Rational rational;
  const auto onSphere = [&random](double radius) {
    Quaternion<double> q = random.direction();
    q.d = 0;
    return q * (radius / std::sqrt(normSquared(q)));
  };
  for (int i = 0; i < 331; ++i)
    (i < 178 ? rational.top : rational.bottom)
        .roots.push_back({floatExact(onSphere(random.between(3.2, 4))), random.between(0, 1)});
  rational.top.powerScale = 251.998 / summedPowers(rational.top);
  rational.bottom.powerScale = 89.3455 / summedPowers(rational.bottom);
  const julia::RationalEvaluator<double> unscaled(rational);
  double mean = 0;
  for (int i = 0; i < 500; ++i) mean += unscaled.logModulus(onSphere(4)) / 500;
  rational.logScale = -mean;
  return rational;
}

// [KD20] does not tell its escape radius. With a small one little overflows; with this one the share of bad cells is
// about that of its Fig. 3 (11.3 %).
constexpr double kEscape = 1e6;
constexpr int kSteps = 3;

std::vector<julia::Point> pointsOfTheBunny(int count) {
  Random random(32);
  std::vector<julia::Point> points;
  for (int i = 0; i < count; ++i) {
    const auto coordinate = [&random] { return static_cast<double>(static_cast<float>(random.between(-4, 4))); };
    points.push_back({coordinate(), coordinate(), coordinate()});
  }
  return points;
}

TEST(Guard, isNeededInCartesianDoubleAndSuffices) {
  const Rational rational = likeTheBunny();
  const auto plain = reference::rationalMap<double>(rational, false);
  const auto guarded = reference::rationalMap<double>(rational, true);
  int bad = 0, tripped = 0, badWithGuard = 0;
  const auto points = pointsOfTheBunny(2000);
  for (const julia::Point& x : points) {
    const Quaternion<double> q{x[0], x[1], x[2], 0};
    if (!std::isfinite(reference::orbit<double>(plain, q, kSteps, kEscape).logModulus)) ++bad;
    const auto orbit = reference::orbit<double>(guarded, q, kSteps, kEscape);
    if (orbit.guarded)
      ++tripped;
    else if (!std::isfinite(orbit.logModulus))
      ++badWithGuard;
  }
  RecordProperty("bad", bad);
  RecordProperty("tripped", tripped);
  EXPECT_GE(bad, 100) << "of 2000";
  EXPECT_EQ(badWithGuard, 0) << "of 2000, guard tripped in " << tripped;
  // Cautious, but not much more than needed.
  EXPECT_GE(tripped, bad);
  EXPECT_LE(tripped, 2 * bad);
}

template <class Real>
class LogPolarNeedsNoGuard : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(LogPolarNeedsNoGuard, Reals);

// Promise of design.md: The log-polar form never leaves "the range of a 32-bit float", without a guard
TYPED_TEST(LogPolarNeedsNoGuard, finiteAndOfTheRightSign) {
  using Real = TypeParam;
  const Rational rational = likeTheBunny();
  const auto points = pointsOfTheBunny(150);
  std::vector<double> field(points.size());
  julia::makeFieldEvaluator<Real>(std::make_shared<julia::RationalMap<Real>>(rational), {},
                                  {.maxIterations = kSteps, .escapeRadius = kEscape})
      ->evaluate(points, field, {});
  const auto wide = reference::rationalMap<Wide>(rational, false);
  const auto bound = law_tests::rationalBound<Real>(rational);
  int judged = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_LT(std::abs(field[i]), julia::kFieldLimit)
        << text(Quaternion<double>{points[i][0], points[i][1], points[i][2], 0});
    const auto expected = law_tests::boundedOrbit<Real>(
        wide, bound, Quaternion<double>{points[i][0], points[i][1], points[i][2], 0}.as<Wide>(), kSteps, kEscape);
    const double l = static_cast<double>(expected.orbit.logModulus);
    ASSERT_TRUE(std::isfinite(l));
    if (!expected.decided || std::abs(l) <= expected.bound) continue;
    ++judged;
    EXPECT_EQ(field[i] < 0, l < 0) << field[i] << " for " << l << " at " << points[i][0] << ' ' << points[i][1] << ' '
                                   << points[i][2];
    EXPECT_LE(std::abs(field[i] - l), expected.bound) << points[i][0] << ' ' << points[i][1] << ' ' << points[i][2];
  }
  this->RecordProperty("judged", judged);
  // The bound must have something to say, or the law is empty.
  EXPECT_GE(judged, 75) << "of 150";
}

}  // namespace
