// SPDX-License-Identifier: Apache-2.0
// Whole orbits: each step is the map's own, and the field is their last logarithm.
#include "julia/orbit_trace.h"

#include "julia/quadratic_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

namespace {

using julia::Point;
using julia::Quaternion;

/// The arrays of a trace.
struct Kept {
  Kept(std::size_t points, int most)
      : row(static_cast<std::size_t>(most) + 1),
        iterates(points * row),
        logModuli(points * row, -7),
        steps(points),
        ends(points) {}
  julia::OrbitTrace trace() { return {iterates, logModuli, steps, ends}; }

  std::size_t row;
  std::vector<Quaternion<double>> iterates;
  std::vector<double> logModuli;
  std::vector<int> steps;
  std::vector<julia::OrbitEnd> ends;
};

// Promise: What F is made of, beside ...
TEST(OrbitTrace, FollowsAQuadraticMap) {
  const Quaternion<double> c{-0.2, 0.6, 0.2, 0.2};
  const julia::OrbitOptions options{.maxIterations = 7, .escapeRadius = 4};
  const std::shared_ptr<const julia::Map<double>> map = std::make_shared<julia::QuadraticMap<double>>(c);
  const auto evaluator = julia::makeFieldEvaluator<double>(map, {.slice = 0.1}, options);
  std::vector<Point> points;
  for (int x = -12; x <= 12; ++x)
    for (int y = -12; y <= 12; ++y)
      for (int z = -12; z <= 12; z += 3) points.push_back({x / 8., y / 8., z / 8. + 0.01});
  points.push_back({4, 1, 0});
  Kept kept(points.size(), options.maxIterations);
  julia::traceOrbits(*evaluator, points, kept.trace());
  std::vector<double> field(points.size());
  std::vector<int> steps(points.size());
  evaluator->evaluate(points, field, steps);
  EXPECT_EQ(kept.steps, steps);
  int escaped = 0, stayed = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t first = i * kept.row, last = first + static_cast<std::size_t>(steps[i]);
    Quaternion<double> q{points[i][0], points[i][1], points[i][2], 0.1};
    EXPECT_EQ(kept.iterates[first], q);
    for (std::size_t k = first + 1; k <= last; ++k) {
      q = q * q + c;
      const double size = std::sqrt(normSquared(q)), near = 1e-9 * (1 + size);
      const Quaternion<double> difference = kept.iterates[k] - q;
      EXPECT_LT(std::sqrt(normSquared(difference)), near) << i << ' ' << k - first;
      EXPECT_NEAR(std::exp(kept.logModuli[k]), size, near) << i << ' ' << k - first;
    }
    for (std::size_t k = last + 1; k < first + kept.row; ++k) EXPECT_EQ(kept.logModuli[k], -7) << i;
    EXPECT_NEAR(field[i], kept.logModuli[last] - std::log(4.), 1e-12) << i;
    EXPECT_EQ(kept.ends[i], field[i] < 0 ? julia::OrbitEnd::Steps : julia::OrbitEnd::Escaped) << i;
    ++(field[i] < 0 ? stayed : escaped);
  }
  EXPECT_GT(escaped, 100);
  EXPECT_GT(stayed, 100);
}

// Promise: What F is made of, beside ...
TEST(OrbitTrace, RefusesSpansOfAnotherSize) {
  const std::shared_ptr<const julia::Map<double>> map =
      std::make_shared<julia::QuadraticMap<double>>(Quaternion<double>{});
  const auto evaluator = julia::makeFieldEvaluator<double>(map, {}, {.maxIterations = 3});
  Kept kept(2, 2);
  const std::vector<Point> points(2);
  EXPECT_THROW(julia::traceOrbits(*evaluator, points, kept.trace()), std::invalid_argument);
}

}  // namespace
