// SPDX-License-Identifier: Apache-2.0
#include "julia/detail.h"

#include <gtest/gtest.h>

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

}  // namespace
