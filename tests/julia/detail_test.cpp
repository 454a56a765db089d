// SPDX-License-Identifier: Apache-2.0
#include "julia/detail.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace {

using julia::RadialMaximum;

/// w of a ball of radius R about the origin whose shell ends at depth @a depth inside and at its surface.
RadialMaximum ball(double radius, double depth) {
  RadialMaximum maximum{.step = 0.01, .maximum = {}};
  for (int k = 0; k < 100; ++k) maximum.maximum.push_back(((k + 1) * maximum.step - radius) / depth);
  return maximum;
}

/// Whether orbits of n steps that start with ln |q_1| <= first stay within the unit ball, step by step.
bool traps(const RadialMaximum& w, double scale, double escape, double first, int n) {
  double l = first;
  for (int i = 1; i < n; ++i) {
    if (!(l < 0)) return false;
    l = std::log(escape) + scale * w.logBound(std::exp(l));
  }
  return l < 0;
}

TEST(WantedScale, TrapsWhatLiesBelowTheShellAndIsTheSmallest) {
  for (const double radius : {0.1, 0.3, 0.5})
    for (const double depth : {0.02, 0.1})
      for (const double escape : {1.5, 2.0, 20.0})
        for (const int n : {2, 3, 6}) {
          const RadialMaximum w = ball(radius, depth);
          const double scale = julia::wantedScale(w, n, escape);
          const double lower = std::log(escape) - scale;
          EXPECT_TRUE(traps(w, scale, escape, lower, n)) << radius << ' ' << depth << ' ' << escape << ' ' << n;
          // A little less, and what lies below the shell is trapped no more.
          const double less = 0.99 * scale;
          EXPECT_FALSE(traps(w, less, escape, std::log(escape) - less, n))
              << radius << ' ' << depth << ' ' << escape << ' ' << n;
        }
}

TEST(WantedScale, ADeeperOriginAllowsRougherDetail) {
  double last = std::numeric_limits<double>::infinity();
  for (const double radius : {0.1, 0.2, 0.3, 0.4}) {
    const double scale = julia::wantedScale(ball(radius, 0.05), 3, 2);
    EXPECT_LT(scale, last) << radius;
    last = scale;
  }
}

TEST(WantedScale, RefusesAnOriginOutside) {
  RadialMaximum outside{.step = 0.1, .maximum = {0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1, 1.2, 1.3, 1.4}};
  EXPECT_THROW(julia::wantedScale(outside, 3, 2), std::invalid_argument);
  EXPECT_THROW(julia::wantedScale(ball(0.3, 0.1), 0, 2), std::invalid_argument);
  EXPECT_THROW(julia::wantedScale(ball(0.3, 0.1), 3, 1), std::invalid_argument);
}

// Promise: K "is taken no larger than ..."
TEST(WantedLaw, TrapsWhatLiesBelowTheShell) {
  int plunges = 0;
  for (const double radius : {0.1, 0.3, 0.5})
    for (const double detail : {0.1, 0.3, 0.5, 0.8, 0.95})
      for (const double outward : {0.0, 0.3})
        for (const int n : {2, 3, 5, 10}) {
          const double surface = -outward / (detail + outward), width = (detail + outward) * radius;
          RadialMaximum w{.step = 0.002, .maximum = {}};
          for (int k = 0; k < 500; ++k) w.maximum.push_back(((k + 1) * w.step - (1 + outward) * radius) / width);
          const julia::DetailLaw law = julia::wantedLaw(w, surface, n, 2);
          EXPECT_LE(law.scale, julia::wantedScale(w, n, 2) * 1.0001);
          plunges += law.plunge > 0;
          double l = law.at(-1);
          for (int i = 1; i < n && l < 0; ++i) l = law.at(w.logBound(std::exp(l)));
          EXPECT_LT(l, 0) << radius << ' ' << detail << ' ' << outward << ' ' << n;
        }
  EXPECT_GT(plunges, 10);
}

// Promise: K "is taken no larger than ..."
TEST(WantedLaw, IsItsLineBentAtItsKnee) {
  const julia::DetailLaw law{.logEscape = 0.7, .scale = 1.8, .plunge = 1.1};
  const julia::Knee knee = law.knee();
  for (double w = -3; w < 3; w += 0.001) {
    const double v = law.line(w);
    ASSERT_NEAR(law.at(w), v + knee.more * std::min(v - knee.at, 0.0), 1e-12) << w;
    ASSERT_LT(law.at(w), law.at(w + 0.001)) << w;
  }
  EXPECT_EQ(law.at(0), 0.7);
  EXPECT_NEAR(law.at(-1), 0.7 - 1.8 - 1.1, 1e-12);
  EXPECT_EQ((julia::DetailLaw{.logEscape = 0.7, .scale = 1.8, .plunge = 0}.knee().more), 0);
}

// Promise: K "is taken no larger than ..."
TEST(WantedLaw, AShallowShellNeedsNoPlunge) {
  for (const double depth : {0.03, 0.06, 0.09}) {
    const RadialMaximum w = ball(0.3, depth);
    const julia::DetailLaw law = julia::wantedLaw(w, 0, 5, 2);
    EXPECT_EQ(law.plunge, 0) << depth;
    EXPECT_EQ(law.scale, julia::wantedScale(w, 5, 2)) << depth;
  }
}

}  // namespace
