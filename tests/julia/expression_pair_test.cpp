// SPDX-License-Identifier: Apache-2.0
// Pairs that the user writes: equal to the built-in ones where they say the same, and refused where they say nothing.
#include "julia/expression_pair.h"

#include "julia/cross_map.h"
#include "julia/evaluator.h"
#include "support/same_bits.h"
#include "support/spatial_orbits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using julia::CrossMap;
using julia::CrossOptions;
using julia::CrossPair;
using julia::CrossScheme;
using julia::ExpressionPair;
using julia::FieldEvaluator;
using julia::OrbitOptions;
using julia::Point;
using law_tests::crossEvaluator;
using law_tests::evaluated;
using law_tests::FieldValues;
using law_tests::pointsInBox;
using law_tests::text;

struct Written {
  CrossPair pair;
  std::string f, g;
};

const std::vector<Written>& builtIn() {
  static const std::vector<Written> pairs = {
      {CrossPair::A, "-r^2*sin2phi, r^2*cos2phi, 0", "-sin2theta/cos2phi, 0, cos2theta"},
      {CrossPair::APrime, "-r^2*sin2phi, r^2*cos2phi, 0", "sin2theta/cos2phi, 0, cos2theta"},
      {CrossPair::B, "1,1,1", "cos(x), cos(y), cos(z)"},
      {CrossPair::C, "x*x, y*y, z*z", "cos(x), cos(y), cos(z)"},
      {CrossPair::D, "-r*r*sin2phi, r*r*cos2phi, 0", "0, 0, 1"},
      {CrossPair::E, "x^2*y, y^2, z^2", "1, cos(z), max(1, 1)"},
  };
  return pairs;
}

template <class Real>
class ExpressionPairs : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(ExpressionPairs, Reals);

// Promise: A user's pair that says what ...
TYPED_TEST(ExpressionPairs, equalToBuiltInOnesGiveTheSameSigns) {
  using Real = TypeParam;
  std::vector<Point> points = pointsInBox(81, 3000, 1.5);
  for (const double x : {0., 0.5, -0.5, 0.75})
    for (const double y : {0., 0.5, -0.5})
      for (const double z : {0., 0.25, -1.}) points.push_back({x, y, z});
  for (const Written& written : builtIn())
    for (const CrossScheme scheme : {CrossScheme::FixedFactor, CrossScheme::Mandelbrot, CrossScheme::Julia}) {
      // Short orbits of floats: rounding grows by up to r^2 or so a step, and by as much as 1 / cos 2phi in (3).
      const OrbitOptions orbit{.maxIterations = sizeof(Real) == 4 ? 4 : 10, .escapeRadius = 4};
      CrossOptions options{.pair = written.pair, .scheme = scheme, .constant = {-0.75, 0.125, 0.25}};
      const FieldValues expected = evaluated(*crossEvaluator<Real>(options, orbit), points);
      options.pair = CrossPair::User;
      options.f = written.f;
      options.g = written.g;
      const FieldValues found = evaluated(*crossEvaluator<Real>(options, orbit), points);
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(found.field[i] < 0, expected.field[i] < 0)
            << written.f << " x " << written.g << " at " << text(points[i]) << ": " << found.field[i] << " for "
            << expected.field[i];
        EXPECT_EQ(found.iterations[i], expected.iterations[i])
            << written.f << " x " << written.g << " at " << text(points[i]);
      }
    }
}

TYPED_TEST(ExpressionPairs, areTheSameInAllThreadsAndOnAllInstructionSets) {
  using Real = TypeParam;
  const auto evaluator = crossEvaluator<Real>(
      {.pair = CrossPair::User, .f = "x*x, sin(y*3), exp(z)", .g = "cos(x), atan2(y, z), x > 0 ? 1 : -1"},
      {.maxIterations = 5, .escapeRadius = 4});
  const std::vector<Point> points = pointsInBox(82, 4000, 2);
  const std::vector<double> expected = evaluated(*evaluator, points).field;
  std::vector<std::vector<double>> found(6);
  std::vector<std::thread> threads;
  for (std::vector<double>& field : found) threads.emplace_back([&] { field = evaluated(*evaluator, points).field; });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& field : found) EXPECT_EQ(field, expected);
  law_tests::expectSameBits<double>([&] { return evaluated(*evaluator, points).field; });
}

TEST(ExpressionPair, whatIsNotFiniteIsOutside) {
  // Undefined for x = 0 only.
  const auto evaluator = crossEvaluator<double>({.pair = CrossPair::User, .f = "1/x, 0, 0", .g = "0, sqrt(z + 1), 0"},
                                                {.maxIterations = 3, .escapeRadius = 2});
  const FieldValues values = evaluated(*evaluator, {{0, 0.5, 0}, {0.5, 0.5, 0}, {0.5, 0, -1.5}});
  EXPECT_EQ(values.field[0], julia::kFieldLimit);
  EXPECT_EQ(values.iterations[0], 1);
  EXPECT_TRUE(std::isfinite(values.field[1]));
  EXPECT_LT(values.field[1], julia::kFieldLimit);
  EXPECT_EQ(values.field[2], julia::kFieldLimit);
}

TEST(ExpressionPair, commasInParenthesesAreArguments) {
  const ExpressionPair pair("min(x, y), max(x, (y)), atan2(y, x)", " x ,y, z ");
  julia::QuaternionBatch<double> p, f, g;
  p.resize(1);
  p.set(0, {1, -2, 0.5, 0});
  pair.evaluate(p, f, g);
  EXPECT_EQ(f.get(0), (julia::Quaternion<double>{-2, 1, std::atan2(-2., 1.), 0}));
  EXPECT_EQ(g.get(0), p.get(0));
}

struct Refusal {
  std::string f, g;
  std::vector<std::string> said;
};

TEST(ExpressionPair, refusesAndNamesThePlace) {
  const std::string good = "x, y, z";
  const Refusal refusals[] = {
      {"x*x, y*q, z", good, {"f is 'x*x, y*q, z'", "character 8", "'q'", "unknown name", "cos2theta"}},
      {good, "cos(x), cosh2(y), 1", {"g is 'cos(x), cosh2(y), 1'", "character 9", "'cosh2'", "unknown name"}},
      {"x, y", good, {"f is 'x, y'", "2 components", "three"}},
      {"", good, {"f is ''", "1 component;"}},
      {good, "x, y, z, r", {"g is 'x, y, z, r'", "4 components"}},
      {"x,, z", good, {"component 2 is empty"}},
      {"x, y, ", good, {"component 3 is empty"}},
      {"x, y, z*", good, {"character 9", "ends too early"}},
      {"x, (y, z", good, {"2 components"}},
      {"x, (y)), z", good, {"character 7", "')'"}},
      {"x, y, cos(z", good, {"character", "parenthesis"}},
      {"x, y, cos(z, x)", good, {"character", "too many arguments"}},
      {"x, y, atan2(z)", good, {"character", "too few arguments"}},
      {"x, y = 3, z", good, {"character 6", "'='", "assigned"}},
      {"x, y, 3 z", good, {"character 9", "'z'"}},
      {"x, \"y\", z", good, {"f is 'x, \"y\", z'"}},
      {"1/0, 0, 0", good, {"character 1", "component 1", "finite", "divide by 0"}},
      {good, "0, 0, sqrt(-1 - x*x)", {"g is", "character 7", "component 3", "finite"}},
  };
  for (const Refusal& refusal : refusals) {
    try {
      const ExpressionPair pair(refusal.f, refusal.g);
      ADD_FAILURE() << "'" << refusal.f << "' and '" << refusal.g << "' were taken";
    } catch (const std::invalid_argument& error) {
      for (const std::string& part : refusal.said)
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << part << " in: " << error.what();
    }
  }
}

}  // namespace
