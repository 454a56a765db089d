// SPDX-License-Identifier: Apache-2.0
// What Cartesian maps prove of whole balls holds at each of their points, in the arithmetic of the evaluator.
#include "julia/cross_map.h"
#include "julia/evaluator.h"
#include "julia/mandelbulb.h"
#include "julia/quadratic_map.h"

#include "support/float128.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace {

using julia::Ball;
using julia::CartesianMap;
using julia::CrossPair;
using julia::CrossScheme;
using julia::Decision;
using julia::Point;
using julia::Quaternion;
using julia::QuaternionBatch;
using law_tests::Random;
using law_tests::text;

template <class Real>
struct Named {
  std::string name;
  std::shared_ptr<const CartesianMap<Real>> map;
  double radius;  ///< escape
};

template <class Real>
std::vector<Named<Real>> mapsThatProve() {
  std::vector<Named<Real>> maps;
  const char* names[] = {"A", "A'", "B", "C", "D", "E"};
  for (const CrossScheme scheme : {CrossScheme::FixedFactor, CrossScheme::Mandelbrot, CrossScheme::Julia})
    for (int pair = 0; pair < 6; ++pair) {
      const julia::CrossOptions options{static_cast<CrossPair>(pair), scheme, {-0.4, 0.2, 0.31}, "", ""};
      maps.push_back({std::string("pair ") + names[pair] + " scheme " + std::to_string(3 + static_cast<int>(scheme)),
                      std::make_shared<julia::CrossMap<Real>>(options), pair < 2 ? 2. : 5.});
    }
  for (const double power : {2., 3., 8., 64.})
    for (const julia::TriplexAngle angle : {julia::TriplexAngle::AbovePlane, julia::TriplexAngle::FromPole}) {
      const std::string name = "power " + std::to_string(power);
      maps.push_back({name, std::make_shared<julia::Mandelbulb<Real>>(julia::MandelbulbOptions{power, angle, {}}), 2});
      const julia::MandelbulbOptions fixed{power, angle, Point{0.3, -0.5, 0.1}};
      maps.push_back({name + " Julia", std::make_shared<julia::Mandelbulb<Real>>(fixed), 2});
    }
  maps.push_back({"quadratic", std::make_shared<julia::QuadraticMandelbrot<Real>>(), 4});
  return maps;
}

template <class Real>
Ball randomBall(Random& random, const CartesianMap<Real>& map, double far) {
  Ball ball{random.inBall() * far, std::exp(random.between(std::log(1e-9), std::log(0.3)))};
  if (map.dimension() == 3) ball.centre.d = 0;
  // On an axis and in a plane of symmetry too.
  const double pick = random.unit();
  if (pick < 0.1) ball.centre.a = ball.centre.b = 0;
  if (pick > 0.9) ball.centre.c = 0;
  if (pick > 0.45 && pick < 0.5) ball.centre = {};
  return ball;
}

/// Points of the ball in Real, each third near its surface.
template <class Real>
QuaternionBatch<Real> pointsOf(Random& random, const CartesianMap<Real>& map, const Ball& ball, std::size_t count) {
  QuaternionBatch<Real> points;
  points.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    Quaternion<double> way = i % 3 == 0 ? random.direction() : random.inBall();
    if (map.dimension() == 3) way.d = 0;
    const Quaternion<Real> q = (ball.centre + way * ball.radius).template as<Real>();
    const bool within = normSquared(q.template as<double>() - ball.centre) <= ball.radius * ball.radius;
    points.set(i, within ? q : ball.centre.template as<Real>());
  }
  return points;
}

template <class Real>
class CartesianBalls : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(CartesianBalls, Reals);

template <class Real>
void expectWithin(const Ball& ball, const QuaternionBatch<Real>& points, const std::string& what) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Quaternion<double> q = points.get(i).template as<double>();
    if (!std::isfinite(normSquared(q))) continue;  // not defined there
    ASSERT_LE(std::sqrt(normSquared(q - ball.centre)), ball.radius) << what << " at " << text(q);
  }
}

TYPED_TEST(CartesianBalls, imagesHoldEachStep) {
  using Real = TypeParam;
  for (const Named<Real>& named : mapsThatProve<Real>()) {
    const CartesianMap<Real>& map = *named.map;
    Random random(77);
    int known = 0;
    for (int k = 0; k < 1500; ++k) {
      // Centres that are numbers of Real, as those that the evaluator asks about.
      const auto exact = [](Ball ball) {
        ball.centre = ball.centre.template as<Real>().template as<double>();
        return ball;
      };
      const Ball start = exact(randomBall(random, map, named.radius)),
                 ball = exact(randomBall(random, map, named.radius));
      const QuaternionBatch<Real> starts = pointsOf(random, map, start, 12), points = pointsOf(random, map, ball, 12);
      QuaternionBatch<Real> carried, next;
      map.begin(starts, carried, next);
      const std::string what = named.name + " from " + text(start.centre) + " within " + std::to_string(start.radius) +
                               " and " + text(ball.centre) + " within " + std::to_string(ball.radius);
      if (const auto image = map.imageOf(start, start, 1)) {
        expectWithin(*image, next, what + ", first step");
        ++known;
      }
      map.step(points, carried, next);
      if (const auto image = map.imageOf(ball, start, 2)) expectWithin(*image, next, what + ", later step");
      if (testing::Test::HasFatalFailure()) return;
    }
    EXPECT_EQ(known, 1500) << named.name;
  }
}

// Promise: "All rounding errors are included ..."
TYPED_TEST(CartesianBalls, decisionsHoldAtEachPoint) {
  using Real = TypeParam;
  for (const Named<Real>& named : mapsThatProve<Real>()) {
    for (const int iterations : {1, 3, 10}) {
      const julia::Embedding embedding{.slice = named.map->dimension() == 4 ? 0.15 : 0};
      const auto evaluator = julia::makeFieldEvaluator<Real>(
          named.map, embedding, {.maxIterations = iterations, .escapeRadius = named.radius});
      Random random(78);
      int decided = 0, undefined = 0;
      for (int k = 0; k < 400; ++k) {
        const Ball ball = randomBall(random, *named.map, 1.2 * named.radius);
        const Point centre{ball.centre.a, ball.centre.b, ball.centre.c};
        Decision decision;
        evaluator->decide(std::span(&centre, 1), ball.radius, std::span(&decision, 1));
        if (decision == Decision::Undecided) continue;
        ++decided;
        undefined += decision == Decision::Inside && !named.map->isDefinedEverywhere();
        std::vector<Point> points;
        for (int i = 0; i < 40; ++i) {
          Quaternion<double> way = i % 3 == 0 ? random.direction() : random.inBall();
          way.d = 0;
          points.push_back(
              {centre[0] + way.a * ball.radius, centre[1] + way.b * ball.radius, centre[2] + way.c * ball.radius});
        }
        std::vector<double> field(points.size());
        evaluator->evaluate(points, field, {});
        for (std::size_t i = 0; i < points.size(); ++i)
          ASSERT_EQ(field[i] < 0, decision == Decision::Inside)
              << named.name << ", " << iterations << " iterations, at "
              << text(Quaternion<double>{points[i][0], points[i][1], points[i][2], 0}) << " about " << text(ball.centre)
              << " within " << ball.radius;
      }
      EXPECT_GT(decided, 60) << named.name << ", " << iterations << " iterations";
      EXPECT_EQ(undefined, 0) << named.name;
    }
  }
}

// Balls that may touch the z axis, about which A turns without bound, are not lost.
TYPED_TEST(CartesianBalls, aBallAboutTheAxisHasAnImage) {
  const julia::CrossMap<TypeParam> map({.pair = CrossPair::A});
  const auto image = map.imageOf({{0, 0, 0.5, 0}, 0.1}, {{}, 0}, 1);
  ASSERT_TRUE(image);
  EXPECT_LE(std::sqrt(normSquared(image->centre)) + image->radius, 0.37);
}

TEST(CartesianImages, whatIsNotKnownIsSaidToBe) {
  const Ball ball{{0.5, 0.1, 0.2, 0}, 0.01};
  const julia::CrossMap<float> user({.pair = CrossPair::User, .f = "x, y, z", .g = "1, 0, 1"});
  EXPECT_FALSE(user.imageOf(ball, ball, 1));
  EXPECT_FALSE(user.isDefinedEverywhere());
  const julia::CrossMap<float> fills({.pair = CrossPair::A, .scheme = CrossScheme::FixedFactor});
  EXPECT_TRUE(fills.imageOf(ball, ball, 1));
  EXPECT_FALSE(fills.imageOf(ball, ball, 2));
  EXPECT_FALSE(julia::Mandelbulb<float>({.power = 2.5}).imageOf(ball, ball, 1));
}

}  // namespace
