// SPDX-License-Identifier: Apache-2.0
/// @file spatial_orbits.h
/// What the tests of maps of R^3 share: points, fields, and the orbits of reference_triplex.h in long double with a
/// running bound of what rounding in Real may have done to them.
#pragma once

#include "julia/cross_map.h"
#include "julia/evaluator.h"
#include "julia/quaternion_batch.h"
#include "support/float128.h"
#include "support/reference_triplex.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace law_tests {

using Long = long double;
using LongVector = julia::reference::Vector<Long>;
using julia::Point;

inline LongVector longVector(const Point& p) { return {p[0], p[1], p[2]}; }

inline Long length(const LongVector& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

/// Exact in float.
inline std::vector<Point> pointsInBox(std::uint64_t seed, int count, double halfWidth) {
  Random random(seed);
  std::vector<Point> points(static_cast<std::size_t>(count));
  for (Point& p : points)
    for (double& x : p) x = static_cast<double>(static_cast<float>(random.between(-halfWidth, halfWidth)));
  return points;
}

template <class Real>
julia::QuaternionBatch<Real> batchOf(const std::vector<Point>& points) {
  julia::QuaternionBatch<Real> batch;
  batch.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) batch.set(i, julia::Embedding{}.quaternion<Real>(points[i]));
  return batch;
}

template <class Real>
std::unique_ptr<julia::FieldEvaluator> crossEvaluator(const julia::CrossOptions& options,
                                                      const julia::OrbitOptions& orbit) {
  return julia::makeFieldEvaluator<Real>(std::make_shared<julia::CrossMap<Real>>(options), {}, orbit);
}

struct FieldValues {
  std::vector<double> field;
  std::vector<int> iterations;
};

inline FieldValues evaluated(const julia::FieldEvaluator& evaluator, const std::vector<Point>& points) {
  FieldValues values{std::vector<double>(points.size(), std::nan("")), std::vector<int>(points.size(), -1)};
  evaluator.evaluate(points, values.field, values.iterations);
  return values;
}

/// One step moves an error of @a delta by the map's derivative, taken by differences; and adds @a rounding.
inline Long errorAfter(const julia::reference::VectorStep<Long>& step, const LongVector& p, bool first,
                       const LongVector& next, Long delta, Long rounding) {
  constexpr Long kDifference = 1e-9L;
  Long squares = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    LongVector moved = p;
    moved[k] += kDifference;
    const auto to = step(moved, first);
    if (!to) return HUGE_VALL;
    for (std::size_t j = 0; j < 3; ++j) squares += ((*to)[j] - next[j]) * ((*to)[j] - next[j]);
  }
  return 2 * std::sqrt(squares) / kDifference * delta + rounding;
}

/// Signs, values and step counts are the reference's wherever the bound leaves no doubt, which must be at @a
/// leastJudged of the points.
/// @param stepOf    the reference's step for the orbit of a point
/// @param rounding  of one step in Real, in units of its epsilon, given p and the next iterate
template <class Real, class StepOf, class Rounding>
void expectReferenceOrbits(const julia::FieldEvaluator& evaluator, const StepOf& stepOf, const Rounding& rounding,
                           const std::vector<Point>& points, const julia::OrbitOptions& options, double leastJudged,
                           const std::string& what) {
  constexpr Long eps = std::numeric_limits<Real>::epsilon();
  const Long escape = options.escapeRadius;
  const FieldValues values = evaluated(evaluator, points);
  int judged = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const julia::reference::VectorStep<Long> step = stepOf(longVector(points[i]));
    LongVector p = longVector(points[i]);
    Long delta = 0, size = length(p);
    int iterations = 0;
    bool undefined = false;
    while (size < escape && iterations < options.maxIterations) {
      const auto next = step(p, iterations == 0);
      ++iterations;
      if (!next) {
        undefined = iterations == 1;
        delta = undefined ? 0 : HUGE_VALL;
        break;
      }
      delta = errorAfter(step, p, iterations == 1, *next, delta, rounding(p, *next) * eps);
      p = *next;
      size = length(p);
      if (!(delta < 0.01L * size) || std::abs(size - escape) <= 2 * delta + 8 * eps * escape) delta = HUGE_VALL;
      if (!(delta < HUGE_VALL)) break;
    }
    if (!(delta < HUGE_VALL)) continue;
    ++judged;
    EXPECT_EQ(values.iterations[i], iterations) << what << " at " << text(points[i]);
    if (undefined) {
      EXPECT_EQ(values.field[i], julia::kFieldLimit) << what << " at " << text(points[i]);
      continue;
    }
    const Long wanted = std::log(size / escape);
    const Long allowed = 2 * delta / size + eps * (4 * std::abs(wanted) + 4 * std::abs(std::log(escape)) + 4);
    EXPECT_NEAR(values.field[i], static_cast<double>(wanted), static_cast<double>(allowed))
        << what << " at " << text(points[i]);
    EXPECT_EQ(values.field[i] < 0, size < escape) << what << " at " << text(points[i]);
  }
  EXPECT_GE(judged, leastJudged * static_cast<double>(points.size())) << what;
}

}  // namespace law_tests
