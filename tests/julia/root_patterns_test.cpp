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
  EXPECT_THROW(julia::pointsOnLine({0, 0, 0}, {1, 0, 0}, 1, 0), std::invalid_argument);
  EXPECT_THROW(julia::appendRings(roots, {0, 0, 0}, {1, 0, 0}, 0, 1, {}), std::invalid_argument);
  EXPECT_THROW(julia::appendRings(roots, {0, 0, 0}, {1, 0, 0}, 1, 0, {}), std::invalid_argument);
  EXPECT_THROW(julia::constantFactor({0, 0, 0, 0}), std::invalid_argument);
}

}  // namespace
