// SPDX-License-Identifier: Apache-2.0
// The bound of quadratic sets: outside of it, every orbit has escaped.
#include "julia/quadratic_map.h"

#include "julia/evaluator.h"
#include "support/float128.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace {

using julia::OrbitOptions;
using julia::Point;
using julia::Quaternion;
using law_tests::Random;
using law_tests::text;

// Promise: "a smaller ball is searched, which is proved ..."
TEST(QuadraticBound, everythingOutsideHasEscaped) {
  Random random(66);
  for (int round = 0; round < 200; ++round) {
    const Quaternion<double> c = random.inBall() * random.between(0, 2);
    const OrbitOptions options{.maxIterations = random.integer(1, 10),
                               .escapeRadius = std::exp(random.between(0.1, 5))};
    const double bound = julia::quadraticBound(c, options.maxIterations, options.escapeRadius);
    EXPECT_LE(bound, options.escapeRadius);
    std::vector<Point> points;
    for (int i = 0; i < 50; ++i) {
      Quaternion<double> u = random.direction();
      u.d = 0;
      // Rounding doubles in each of up to 10 steps; all else is a law.
      u = u * (bound * (1 + 1e-11 + (i % 2) * random.unit()) / std::sqrt(normSquared(u)));
      points.push_back({u.a, u.b, u.c});
    }
    std::vector<double> field(points.size());
    julia::makeFieldEvaluator<double>(std::make_shared<julia::QuadraticMap<double>>(c), {}, options)
        ->evaluate(points, field, {});
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_GE(field[i], 0) << text(points[i]) << " c = " << text(c) << " n = " << options.maxIterations << " escape "
                             << options.escapeRadius;
  }
}

TEST(QuadraticBound, tightWithoutConstant) {
  for (const double escape : {1.5, 20., 1e6})
    for (const int n : {1, 2, 3, 8})
      EXPECT_NEAR(julia::quadraticBound({}, n, escape), std::pow(escape, std::pow(0.5, n)), 1e-13)
          << escape << ' ' << n;
}

TEST(QuadraticBound, fallsWithTheSteps) {
  for (const double size : {0., 0.3, 1., 5.}) {
    double before = 20;
    for (int n = 1; n < 30; ++n) {
      const double bound = julia::quadraticBound({0, size, 0, 0}, n, 20);
      EXPECT_LE(bound, before) << size << ' ' << n;
      before = bound;
    }
    // Down to the fixed point r^2 - |c| = r.
    EXPECT_NEAR(before, (1 + std::sqrt(1 + 4 * size)) / 2, 1e-6) << size;
  }
}

}  // namespace
