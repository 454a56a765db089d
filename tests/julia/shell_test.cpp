// SPDX-License-Identifier: Apache-2.0
// The shell interval: known answers, and soundness against every worst orbit r -> m(r).
#include "julia/shell.h"

#include "support/float128.h"
#include "support/limits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace {

using julia::RadialMaximum;
using julia::shellInterval;
using law_tests::Random;
using test_limits::kInfinity;

std::string tableText(const RadialMaximum& table) {
  std::ostringstream out;
  out << "step " << table.step << ':';
  for (const double bound : table.maximum) out << ' ' << bound;
  return out.str();
}

TEST(RadialMaximum, boundsTheBallsOfTheTable) {
  const RadialMaximum table{0.25, {-3, -1, 2}};
  for (const double r : {0., 1e-300, 0.1, 0.25}) EXPECT_EQ(table.logBound(r), -3) << r;
  for (const double r : {0.2500001, 0.4, 0.5}) EXPECT_EQ(table.logBound(r), -1) << r;
  for (const double r : {0.5000001, 0.75}) EXPECT_EQ(table.logBound(r), 2) << r;
  for (const double r : {0.7500001, 1., 1e300, kInfinity}) EXPECT_EQ(table.logBound(r), kInfinity) << r;
  EXPECT_EQ((RadialMaximum{0.25, {}}.logBound(0)), kInfinity);
}

TEST(ShellInterval, knownAnswers) {
  const auto lower = [](const RadialMaximum& table, int n) { return shellInterval(table, n, 20).lower; };
  // Trapped by the first ball, and the table ends there.
  EXPECT_EQ(lower({0.5, {-1}}, 2), std::log(0.5));
  EXPECT_EQ(lower({0.5, {-1}}, 100), std::log(0.5));
  // A ball of radius 1 is not below 1.
  EXPECT_EQ(lower({0.5, {-1, -1}}, 2), std::log(0.5));
  // The last ball with m < 1; it maps to e^-0.5 = 0.607, which stays.
  const RadialMaximum trapping{0.25, {-2, -1.5, -0.5, 0.5}};
  for (const int n : {2, 3, 10}) EXPECT_EQ(lower(trapping, n), std::log(0.75)) << n;
  // Here a ball maps to e^-0.05 = 0.95, e^-0.1 = 0.90 or e^-0.2 = 0.82, all in the ball that leaves.
  const RadialMaximum leaking{0.25, {-0.2, -0.1, -0.05, 0.1}};
  EXPECT_EQ(lower(leaking, 2), std::log(0.75));
  EXPECT_EQ(lower(leaking, 3), -kInfinity);
  // The same where the table ends before 0.82.
  EXPECT_EQ(lower({0.25, {-0.2}}, 2), std::log(0.25));
  EXPECT_EQ(lower({0.25, {-0.2}}, 3), -kInfinity);
  // One ball survives n = 3 and not n = 4: 0.25 -> e^-0.7 = 0.497 -> e^-0.5 = 0.607 -> out.
  const RadialMaximum slow{0.25, {-0.7, -0.5, 0.1}};
  EXPECT_EQ(lower(slow, 2), std::log(0.5));
  EXPECT_EQ(lower(slow, 3), std::log(0.25));
  EXPECT_EQ(lower(slow, 4), -kInfinity);
}

TEST(ShellInterval, originOutsideTrapsNothing) {
  for (const double outside : {0., 0.1, 100.})
    for (const int n : {2, 3, 50})
      EXPECT_EQ(shellInterval({0.125, {outside, outside, outside}}, n, 20).lower, -kInfinity) << outside << ' ' << n;
  EXPECT_EQ(shellInterval({0.125, {}}, 3, 20).lower, -kInfinity);
}

TEST(ShellInterval, oneStepKnowsEverySign) {
  for (const RadialMaximum& table : {RadialMaximum{0.25, {-1}}, RadialMaximum{0.25, {5}}, RadialMaximum{0.25, {}}})
    EXPECT_EQ(shellInterval(table, 1, 20).lower, 0) << tableText(table);
}

TEST(ShellInterval, upperIsLogEscape) {
  for (const double escape : {1.5, 20., 1e9})
    for (const int n : {1, 3}) EXPECT_EQ(shellInterval({0.25, {-1}}, n, escape).upper, std::log(escape));
}

/// Whether the worst orbit from radius @a r, r -> max of e^E over the smallest ball of the table that holds r, stays
/// below 1 for @a steps steps.
bool worstOrbitStays(const RadialMaximum& table, double r, int steps) {
  for (int i = 0; i < steps; ++i) {
    std::size_t ball = 0;
    while (ball < table.maximum.size() && r > table.step * static_cast<double>(ball + 1)) ++ball;
    if (ball == table.maximum.size()) return false;
    r = std::exp(table.maximum[ball]);
    if (!(r < 1)) return false;
  }
  return true;
}

RadialMaximum randomTable(Random& random) {
  RadialMaximum table;
  table.step = random.between(0.01, 0.3);
  // From deep inside to outside at random speed, in steps and in plateaus; some tables end early, some begin outside.
  double value = random.between(-4, 0.3);
  for (int k = random.integer(1, 60); k > 0; --k) {
    table.maximum.push_back(value);
    if (random.integer(0, 2) != 0) value += random.unit() * random.unit() * 0.6;
  }
  return table;
}

// Promise of design.md: "E may be clamped to the interval (ln r_in, ln escape) without changing any sign"
TEST(ShellInterval, soundAndTightForRandomTables) {
  Random random(40);
  // exp(log(r)) may leave a ball by a rounding.
  constexpr double kInward = 1 - 1e-12;
  int trapped = 0;
  for (int round = 0; round < 4000; ++round) {
    const RadialMaximum table = randomTable(random);
    const int n = random.integer(2, 8);
    const double lower = shellInterval(table, n, 20).lower;
    const double r = std::exp(lower);
    if (lower > -kInfinity) {
      ++trapped;
      ASSERT_LT(lower, 0) << tableText(table);
      for (const double part : {1e-9, 0.1, 0.5, 0.9, 0.999, 1.})
        ASSERT_TRUE(worstOrbitStays(table, part * r * kInward, n - 1))
            << part * r << ' ' << n << ' ' << tableText(table);
      ASSERT_TRUE(worstOrbitStays(table, random.unit() * r, n - 1)) << n << ' ' << tableText(table);
    }
    // The next ball of the table leaves, or is not below 1.
    const double next = (std::round(r / table.step) + 1) * table.step;
    ASSERT_FALSE(next < 1 && worstOrbitStays(table, next * kInward, n - 1))
        << next << ' ' << n << ' ' << tableText(table);
  }
  EXPECT_GE(trapped, 1000) << "of 4000: the tables are too wild to test anything";
}

TEST(ShellInterval, neverGrowsWithTheSteps) {
  Random random(41);
  for (int round = 0; round < 1000; ++round) {
    const RadialMaximum table = randomTable(random);
    double before = shellInterval(table, 1, 20).lower;
    for (int n = 2; n < 12; ++n) {
      const double lower = shellInterval(table, n, 20).lower;
      ASSERT_LE(lower, before) << n << ' ' << tableText(table);
      before = lower;
    }
  }
}

TEST(ShellInterval, refusesWhatNoOrbitHas) {
  const RadialMaximum table{0.25, {-1}};
  for (const int n : {0, -1, 1'000'000'000}) EXPECT_THROW(shellInterval(table, n, 20), std::invalid_argument) << n;
  for (const double escape : {1., 0., -20., std::nan(""), kInfinity})
    EXPECT_THROW(shellInterval(table, 3, escape), std::invalid_argument) << escape;
}

}  // namespace
