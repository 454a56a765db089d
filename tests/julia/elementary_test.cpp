// SPDX-License-Identifier: Apache-2.0
// The elementary functions: near the true ones, exact where their header says so, and C's special values.
#include "julia/elementary.h"

#include "support/float128.h"
#include "support/limits.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace {

namespace elementary = julia::elementary;
using law_tests::Random;
using law_tests::Wide;
using test_limits::kInfinity;

constexpr int kTries = 4000;

/// The distance of a result from the truth, in units of the last place.
double unitsOff(double result, const Wide& truth) {
  const auto near = static_cast<double>(truth);
  if (!std::isfinite(near) || !std::isfinite(result))
    return result == near || (std::isnan(result) && std::isnan(near)) ? 0 : kInfinity;
  const int exponent = near == 0 ? -1074 : std::max(std::ilogb(near) - 52, -1074);
  return std::abs(static_cast<double>((Wide(result) - truth) / std::ldexp(1.0, exponent)));
}

using Real1 = double (*)(double);
using Real2 = double (*)(double, double);

void expectNear(const char* name, Real1 function, const std::function<Wide(const Wide&)>& truth, double units,
                const std::function<double(Random&)>& draw) {
  Random random(7);
  double worst = 0, where = 0;
  for (int i = 0; i < kTries; ++i) {
    const double x = draw(random), off = unitsOff(function(x), truth(x));
    if (!(off <= worst)) worst = off, where = x;
  }
  EXPECT_LE(worst, units) << name << " of " << std::hexfloat << where;
}

void expectNear(const char* name, Real2 function, const std::function<Wide(const Wide&, const Wide&)>& truth,
                double units, const std::function<double(Random&)>& drawX,
                const std::function<double(Random&)>& drawY) {
  Random random(7);
  double worst = 0, atX = 0, atY = 0;
  for (int i = 0; i < kTries; ++i) {
    const double x = drawX(random), y = drawY(random), off = unitsOff(function(x, y), truth(x, y));
    if (!(off <= worst)) worst = off, atX = x, atY = y;
  }
  EXPECT_LE(worst, units) << name << " of " << std::hexfloat << atX << " and " << atY;
}

std::function<double(Random&)> evenly(double low, double high) {
  return [=](Random& random) { return random.between(low, high); };
}
/// Of all sizes, and positive.
double ofAnySize(Random& random) { return std::ldexp(random.between(0.5, 1), random.integer(-1070, 1024)); }
double ofAnySizeAndSign(Random& random) { return random.unit() < 0.5 ? -ofAnySize(random) : ofAnySize(random); }
/// Next to multiples of a quarter turn.
double nearQuarters(Random& random) { return random.integer(-1000000, 1000000) * (std::numbers::pi / 2); }

#define TRUTH(name) [](const Wide& x) -> Wide { return name(x); }
#define TRUTH2(name) [](const Wide& x, const Wide& y) -> Wide { return name(x, y); }

// Promise: "neither the instruction set ..."
TEST(Elementary, LogarithmsAreNear) {
  for (const auto& draw : {std::function<double(Random&)>(ofAnySize), evenly(0.5, 2), evenly(1 - 1e-9, 1 + 1e-9)}) {
    expectNear("log", elementary::log, TRUTH(log), 0.51, draw);
    expectNear("log2", elementary::log2, TRUTH(boost::multiprecision::log2), 0.51, draw);
    expectNear("log10", elementary::log10, TRUTH(log10), 0.51, draw);
  }
  expectNear("log1p", elementary::log1p, TRUTH(boost::multiprecision::log1p), 2, evenly(-1, 2));
  expectNear("log1p", elementary::log1p, TRUTH(boost::multiprecision::log1p), 2, evenly(-1e-8, 1e-8));
}

// Promise: "neither the instruction set ..."
TEST(Elementary, ExponentialsAreNear) {
  expectNear("exp", elementary::exp, TRUTH(exp), 0.55, evenly(-708, 709.7));
  expectNear("exp", elementary::exp, TRUTH(exp), 0.55, evenly(-1, 1));
  // Below the normal numbers the result is rounded once more.
  expectNear("exp", elementary::exp, TRUTH(exp), 1, evenly(-746, -708));
  expectNear("exp2", elementary::exp2, TRUTH(boost::multiprecision::exp2), 0.55, evenly(-1021, 1023.9));
  expectNear("expm1", elementary::expm1, TRUTH(boost::multiprecision::expm1), 2, evenly(-2, 2));
  expectNear("expm1", elementary::expm1, TRUTH(boost::multiprecision::expm1), 2, evenly(-1e-5, 1e-5));
  expectNear("expm1", elementary::expm1, TRUTH(boost::multiprecision::expm1), 2, evenly(-50, 700));
  for (const double high : {3., 30., 700.}) {
    expectNear("sinh", elementary::sinh, TRUTH(sinh), 3, evenly(-high, high));
    expectNear("cosh", elementary::cosh, TRUTH(cosh), 3, evenly(-high, high));
    expectNear("tanh", elementary::tanh, TRUTH(tanh), 3, evenly(-high, high));
  }
}

// Promise: "neither the instruction set ..."
TEST(Elementary, PowersAreNear) {
  expectNear("pow", elementary::pow, TRUTH2(pow), 0.6, ofAnySize, evenly(-0.9, 0.9));
  expectNear("pow", elementary::pow, TRUTH2(pow), 0.6, evenly(0.6, 1.6), evenly(-1000, 1000));
  expectNear("pow", elementary::pow, TRUTH2(pow), 0.51, evenly(-2, 2),
             [](Random& random) { return static_cast<double>(random.integer(-900, 900)); });
  expectNear("cbrt", elementary::cbrt, TRUTH(boost::multiprecision::cbrt), 0.51, ofAnySizeAndSign);
  const Real2 hypot = elementary::hypot;
  for (const auto& draw : {std::function<double(Random&)>(ofAnySizeAndSign), evenly(-3, 3)})
    expectNear("hypot", hypot, TRUTH2(boost::multiprecision::hypot), 1.5, draw, draw);
}

// Promise: "neither the instruction set ..."
TEST(Elementary, AnglesAreNear) {
  for (const auto& draw : {evenly(-7, 7), evenly(-1e6, 1e6), std::function<double(Random&)>(nearQuarters)}) {
    expectNear("sin", elementary::sin, TRUTH(sin), 3, draw);
    expectNear("cos", elementary::cos, TRUTH(cos), 3, draw);
    expectNear("tan", elementary::tan, TRUTH(tan), 5, draw);
  }
  for (const auto& draw : {std::function<double(Random&)>(ofAnySizeAndSign), evenly(-3, 3)}) {
    expectNear("atan", elementary::atan, TRUTH(atan), 6, draw);
    expectNear("atan2", elementary::atan2, TRUTH2(atan2), 6, draw, draw);
  }
  expectNear("asin", elementary::asin, TRUTH(asin), 6, evenly(-1, 1));
  expectNear("acos", elementary::acos, TRUTH(acos), 6, evenly(-1, 1));
}

TEST(Elementary, SineAndCosineOfLargeAnglesAreThoseOfTheExactNumber) {
  // Each follows from that of half the angle: sin 2a = 2 sin a cos a.
  for (const double small : {0.7, 1.25, 3.0}) {
    Wide sine = sin(Wide(small)), cosine = cos(Wide(small));
    double x = small;
    for (int doubling = 1; doubling <= 40; ++doubling) {
      const Wide before = sine;
      sine = 2 * sine * cosine;
      cosine = 1 - 2 * before * before;
      x *= 2;
      // Errors double too; what is left of 113 bits after 40 doublings is more than 60.
      EXPECT_NEAR(elementary::sin(x), static_cast<double>(sine), 3e-16) << small << " times 2^" << doubling;
      EXPECT_NEAR(elementary::cos(x), static_cast<double>(cosine), 3e-16) << small << " times 2^" << doubling;
    }
  }
  // [W. Kahan]: the double that lies nearest to a multiple of pi/2.
  EXPECT_NEAR(elementary::cos(6381956970095103 * 0x1p797) / -4.6871659242546276e-19, 1, 1e-14);
  EXPECT_EQ(elementary::sin(-1e300), -elementary::sin(1e300));
}

// Promise: "neither the instruction set ..."
TEST(Elementary, ExactWhereTheResultIsANumber) {
  for (int n = -300; n <= 300; ++n) {
    EXPECT_EQ(elementary::log2(std::ldexp(1, n)), n);
    EXPECT_EQ(elementary::exp2(n), std::ldexp(1, n));
    EXPECT_EQ(elementary::pow(2, n), std::ldexp(1, n));
    EXPECT_EQ(elementary::cbrt(static_cast<double>(n) * n * n), n);
    EXPECT_EQ(elementary::pow(n, 3), static_cast<double>(n) * n * n);
  }
  double power = 1;
  for (int n = 0; n <= 22; ++n, power *= 10) {
    EXPECT_EQ(elementary::pow(10, n), power);
    EXPECT_EQ(elementary::log10(power), n);
  }
  EXPECT_EQ(elementary::hypot(3, 4), 5);
  EXPECT_EQ(elementary::hypot(2, 3, 6), 7);
  EXPECT_EQ(elementary::hypot(std::ldexp(3, 900), std::ldexp(4, 900)), std::ldexp(5, 900));
  EXPECT_EQ(elementary::hypot(std::ldexp(3, -900), std::ldexp(4, -900)), std::ldexp(5, -900));
}

/// The C library's, whose special values are those of Annex F.
void expectSpecial(const char* name, Real1 function, Real1 model) {
  for (const double x : {0., 1., 2., 0.5, 3., 1e308, 5e-324, kInfinity, 710., 750., 1e5, 9007199254740992.})
    for (const double signedX : {x, -x}) {
      const double result = function(signedX), known = model(signedX);
      EXPECT_EQ(std::isnan(result), std::isnan(known)) << name << " of " << signedX;
      if (std::isnan(known)) continue;
      EXPECT_EQ(std::signbit(result), std::signbit(known)) << name << " of " << signedX;
      EXPECT_LE(unitsOff(result, known), 6) << name << " of " << signedX << " is " << result << ", not " << known;
    }
  EXPECT_TRUE(std::isnan(function(std::numeric_limits<double>::quiet_NaN()))) << name;
}

void expectSpecial(const char* name, Real2 function, Real2 model) {
  const double values[] = {0.,
                           1.,
                           2.,
                           0.5,
                           3.,
                           4.5,
                           1e308,
                           5e-324,
                           kInfinity,
                           1e5,
                           1025.,
                           9007199254740991.,
                           -0.,
                           -1.,
                           -2.,
                           -0.5,
                           -3.,
                           -1e308,
                           -5e-324,
                           -kInfinity,
                           -1e5,
                           -1025.,
                           -9007199254740991.,
                           std::numeric_limits<double>::quiet_NaN()};
  for (const double x : values)
    for (const double y : values) {
      const double result = function(x, y), known = model(x, y);
      EXPECT_EQ(std::isnan(result), std::isnan(known)) << name << " of " << x << " and " << y;
      if (std::isnan(known)) continue;
      EXPECT_EQ(std::signbit(result), std::signbit(known)) << name << " of " << x << " and " << y;
      EXPECT_LE(unitsOff(result, known), 6) << name << " of " << x << " and " << y << " is " << result;
    }
}

TEST(Elementary, SpecialValuesAreThoseOfC) {
#define SPECIAL(name) expectSpecial(#name, Real1(elementary::name), Real1(std::name))
  SPECIAL(log);
  SPECIAL(log2);
  SPECIAL(log10);
  SPECIAL(log1p);
  SPECIAL(exp);
  SPECIAL(exp2);
  SPECIAL(expm1);
  SPECIAL(cbrt);
  SPECIAL(sin);
  SPECIAL(cos);
  SPECIAL(tan);
  SPECIAL(asin);
  SPECIAL(acos);
  SPECIAL(atan);
  SPECIAL(sinh);
  SPECIAL(cosh);
  SPECIAL(tanh);
#define SPECIAL2(name) expectSpecial(#name, Real2(elementary::name), Real2(std::name))
  SPECIAL2(pow);
  SPECIAL2(atan2);
  SPECIAL2(hypot);
}

}  // namespace
