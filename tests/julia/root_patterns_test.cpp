// SPDX-License-Identifier: Apache-2.0
// Patterns of roots: what each family promises of its points, and what its factors make of a versor.
#include "julia/root_patterns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace {

using julia::Embedding;
using julia::Point;
using julia::Quaternion;
using julia::Root;

const Point kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, -2}, {0.5, 0.8, 0.3}, {-1, 1e-3, 2}};

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double lengthOf(const Point& a) { return std::sqrt(dot(a, a)); }
Point unit(const Point& a) { return {a[0] / lengthOf(a), a[1] / lengthOf(a), a[2] / lengthOf(a)}; }

/// x turned about a unit vector by Rodrigues' formula.
Point turned(const Point& x, const Point& n, double angle) {
  const Point c{n[1] * x[2] - n[2] * x[1], n[2] * x[0] - n[0] * x[2], n[0] * x[1] - n[1] * x[0]};
  Point result{};
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = x[i] * std::cos(angle) + c[i] * std::sin(angle) + n[i] * dot(n, x) * (1 - std::cos(angle));
  return result;
}

double nearest(const Point& x, const std::vector<Point>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (const Point& point : points) least = std::min(least, lengthOf(minus(x, point)));
  return least;
}

TEST(RootPatterns, lineHasEqualStepsAlongItsAxis) {
  const Point centre{0.1, -0.2, 0.3};
  for (const Point& axis : kAxes) {
    const std::vector<Point> points = julia::pointsOnLine(centre, axis, 0.8, 5);
    ASSERT_EQ(points.size(), 5U);
    for (int i = 0; i < 5; ++i) {
      const Point offset = minus(points[static_cast<std::size_t>(i)], centre);
      EXPECT_NEAR(dot(offset, unit(axis)), 0.16 * (i - 2), 1e-14);
      EXPECT_NEAR(lengthOf(offset), std::abs(0.16 * (i - 2)), 1e-14);
    }
  }
}

TEST(RootPatterns, circleHasSymmetryOfItsOrder) {
  const Point centre{0.3, 0.1, -0.2};
  for (const Point& axis : kAxes)
    for (const int order : {1, 2, 3, 7, 12}) {
      SCOPED_TRACE(order);
      const std::vector<Point> points = julia::pointsOnCircle(centre, axis, 0.25, order);
      ASSERT_EQ(points.size(), static_cast<std::size_t>(order));
      for (const Point& point : points) {
        const Point offset = minus(point, centre);
        EXPECT_NEAR(lengthOf(offset), 0.25, 1e-14);
        EXPECT_NEAR(dot(offset, unit(axis)), 0, 1e-14);
        Point image = turned(offset, unit(axis), 2 * std::numbers::pi / order);
        for (std::size_t i = 0; i < 3; ++i) image[i] += centre[i];
        EXPECT_LT(nearest(image, points), 1e-13);
        if (order > 1) {
          image = turned(offset, unit(axis), std::numbers::pi / order);
          for (std::size_t i = 0; i < 3; ++i) image[i] += centre[i];
          EXPECT_GT(nearest(image, points), 0.01);
        }
      }
    }
}

TEST(RootPatterns, helixScrewsIntoItself) {
  const int count = 24;
  for (const Point& axis : kAxes) {
    const Point n = unit(axis);
    const std::vector<Point> points = julia::pointsOnHelix({0, 0, 0}, axis, 0.1, 0.9, 3, count);
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      Point next = turned(points[i], n, 2 * std::numbers::pi * 3 / count);
      for (std::size_t k = 0; k < 3; ++k) next[k] += 0.9 / count * n[k];
      EXPECT_LT(lengthOf(minus(next, points[i + 1])), 1e-13);
      const Point foot =
          minus(points[i], {dot(points[i], n) * n[0], dot(points[i], n) * n[1], dot(points[i], n) * n[2]});
      EXPECT_NEAR(lengthOf(foot), 0.1, 1e-13);
    }
  }
}

TEST(RootPatterns, latticeFillsItsBox) {
  const Point low{-0.5, -0.3, 0}, high{0.5, 0.32, 0.01};
  const std::vector<Point> points = julia::pointsOfLattice(low, high, 0.2);
  EXPECT_EQ(points.size(), 5U * 3U * 1U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_GE(points[i][axis], low[axis]);
      EXPECT_LE(points[i][axis], high[axis]);
    }
    // The mirror image in the middle of the box is a node too.
    EXPECT_LT(
        nearest({low[0] + high[0] - points[i][0], low[1] + high[1] - points[i][1], low[2] + high[2] - points[i][2]},
                points),
        1e-13);
    std::vector<Point> others = points;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_NEAR(nearest(points[i], others), 0.2, 1e-13);
  }
}

TEST(RootPatterns, surfacePointsLieOnItAndFarApart) {
  const auto egg = [](const Point& x) { return std::hypot(x[0], x[1], x[2]) - 0.4; };
  const int count = 30;
  const std::vector<Point> points = julia::pointsOnSurface(egg, {-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}, 0.02, count, 7);
  ASSERT_EQ(points.size(), static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(egg(points[i]), 0, 1e-9);
    std::vector<Point> others = points;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    // Discs of half the distance that a hexagonal packing would have.
    EXPECT_GT(nearest(points[i], others), 0.5 * 0.4 * std::sqrt(8 * std::numbers::pi / (std::sqrt(3.0) * count)));
  }
  EXPECT_EQ(points, julia::pointsOnSurface(egg, {-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}, 0.02, count, 7));
  EXPECT_NE(points, julia::pointsOnSurface(egg, {-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}, 0.02, count, 8));
  EXPECT_THROW(julia::pointsOnSurface([](const Point&) { return 1.0; }, {0, 0, 0}, {1, 1, 1}, 0.02, 1, 1),
               std::invalid_argument);
  EXPECT_THROW(julia::pointsOnSurface(nullptr, {0, 0, 0}, {1, 1, 1}, 0.02, 3, 1), std::invalid_argument);
}

TEST(RootPatterns, jitterIsThatOfItsSeed) {
  const std::vector<Point> points(20'000, Point{1, 2, 3});
  const std::vector<Point> moved = julia::jittered(points, 0.1, 5);
  EXPECT_EQ(moved, julia::jittered(points, 0.1, 5));
  EXPECT_NE(moved, julia::jittered(points, 0.1, 6));
  EXPECT_EQ(points, julia::jittered(points, 0, 5));
  double squares = 0;
  for (const Point& point : moved) squares += dot(minus(point, points[0]), minus(point, points[0]));
  EXPECT_NEAR(std::sqrt(squares / (3.0 * static_cast<double>(points.size()))), 0.1, 0.002);
}

TEST(RootPatterns, fanTurnsByItsAngle) {
  const std::vector<Point> axes = julia::fanOfAxes({0, 2, 0}, {0, 1, 1}, 0.2, 10);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    EXPECT_NEAR(axes[i][0], 0, 1e-15);
    EXPECT_NEAR(axes[i][1], std::cos(0.2 * static_cast<double>(i)), 1e-14);
    EXPECT_NEAR(axes[i][2], std::sin(0.2 * static_cast<double>(i)), 1e-14);
  }
  EXPECT_THROW(julia::fanOfAxes({0, 1, 0}, {0, -3, 0}, 0.2, 4), std::invalid_argument);
}

// Rings: the component of the value along the real axis depends on the angle to the axis alone, and is the cosine of
// that angle, taken as often as there are factors.
TEST(RootPatterns, ringsAreRingsAboutTheirAxis) {
  const Point t{0.1, 0.05, -0.2};
  for (const julia::DropAxis dropped : {julia::DropAxis::I, julia::DropAxis::J, julia::DropAxis::K})
    for (const Point& axis : kAxes)
      for (const int count : {1, 4, 9}) {
        const Embedding embedding{0, dropped};
        julia::Rational rational;
        julia::appendRings(rational.top.roots, t, axis, 1, count, embedding);
        const julia::RationalEvaluator<double> versor(rational);
        for (const double angle : {0.2, 1.0, 2.5})
          for (const double around : {0.0, 1.0, 4.0}) {
            const Point n = unit(axis);
            const Point side = unit(std::abs(n[0]) < 0.9 ? Point{0, -n[2], n[1]} : Point{-n[1], n[0], 0});
            const Point out = turned(side, n, around);
            Point x{};
            for (std::size_t i = 0; i < 3; ++i) x[i] = t[i] + 0.3 * (std::cos(angle) * n[i] + std::sin(angle) * out[i]);
            EXPECT_NEAR(versor.versor(embedding.quaternion<double>(x)).a, std::cos(count * angle), 1e-4)
                << "axis " << axis[0] << ' ' << axis[1] << ' ' << axis[2] << ", " << count << " times";
          }
      }
}

// (q - t)^-1 points as the conjugate of q - t does, so a system of rings with P = -1 undoes one about the real axis.
TEST(RootPatterns, inverseRingsUndoRings) {
  for (const int power : {1, 3}) {
    julia::Rational rational;
    julia::appendRings(rational.top.roots, {0.1, 0, 0}, {1, 0, 0}, power, 4, {});
    julia::appendRings(rational.top.roots, {0.1, 0, 0}, {2, 0, 0}, -power, 4, {});
    EXPECT_NEAR(julia::RationalEvaluator<double>(rational).versor(Quaternion<double>{0.2, 0.3, -0.1, 0}).a, 1, 1e-14);
  }
}

TEST(RootPatterns, constantsHaveTheModulusOne) {
  julia::Rational rational;
  julia::appendRings(rational.top.roots, {0, 0, 0}, {0, 1, 0}, 1, 6, {});
  rational.logScale = julia::unitConstants(rational.top.roots);
  const double l = julia::RationalEvaluator<double>(rational).logModulus(Quaternion<double>{0.3, 0.4, 0, 0});
  EXPECT_NEAR(l, 6 * std::log(0.5), 1e-5);
}

TEST(RootPatterns, badNumbersAreRefused) {
  std::vector<Root> roots;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(julia::pointsOnLine({0, 0, 0}, {0, 0, 0}, 1, 3), std::invalid_argument);
  EXPECT_THROW(julia::pointsOnLine({0, 0, nan}, {1, 0, 0}, 1, 3), std::invalid_argument);
  EXPECT_THROW(julia::pointsOnCircle({0, 0, 0}, {1, 0, 0}, 1, 0), std::invalid_argument);
  EXPECT_THROW(julia::pointsOfLattice({0, 0, 0}, {1, 1, 1}, 0), std::invalid_argument);
  EXPECT_THROW(julia::pointsOfLattice({0, 0, 0}, {1, 1, 1}, 1e-4), std::invalid_argument);
  EXPECT_THROW(julia::pointsOfLattice({0, 1, 0}, {1, 0, 1}, 0.1), std::invalid_argument);
  EXPECT_THROW(julia::appendRings(roots, {0, 0, 0}, {1, 0, 0}, 0, 1, {}), std::invalid_argument);
  EXPECT_THROW(julia::appendRings(roots, {0, 0, 0}, {1, 0, 0}, 1, 0, {}), std::invalid_argument);
  EXPECT_THROW(julia::constantFactor({0, 0, 0, 0}), std::invalid_argument);
}

}  // namespace
