// SPDX-License-Identifier: Apache-2.0
#include "julia/root_patterns.h"

#include "require.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {
namespace {

constexpr int kMostPoints = 1'000'000;
constexpr int kMostFactorPower = 1000;
// Far compared with every shape, so that (q - t) hardly turns, and within the 1e9 that a rational accepts.
constexpr double kFar = 1e6;

void requireFinitePoint(const Point& point, const char* what) {
  for (const double x : point) require(std::isfinite(x), std::string(what) + " is not finite");
}

void requireCount(int count) {
  require(count >= 1 && count <= kMostPoints,
          "the number of points is " + std::to_string(count) + "; it must be 1 to " + std::to_string(kMostPoints));
}

Point plus(const Point& a, const Point& b, double factor = 1) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Point unitVector(const Point& axis) {
  requireFinitePoint(axis, "the axis");
  const double length = elementary::hypot(axis[0], axis[1], axis[2]);
  require(length > 0 && std::isfinite(length), "the axis has no direction; give one of a length above 0");
  return {axis[0] / length, axis[1] / length, axis[2] / length};
}

bool isFar(const Root& root) {
  // A root of a pattern is never as far away, and a constant factor that was scaled or moved is not a constant any
  // more.
  const Quaternion<double>& t = root.position;
  return elementary::hypot(elementary::hypot(t.a, t.b), elementary::hypot(t.c, t.d)) > kFar / 2;
}

}  // namespace

std::vector<Point> pointsOnLine(const Point& centre, const Point& axis, double length, int count) {
  requireCount(count);
  requireFinitePoint(centre, "the centre");
  require(std::isfinite(length), "the length is not finite");
  const Point along = unitVector(axis);
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) points.push_back(plus(centre, along, length * ((i + 0.5) / count - 0.5)));
  return points;
}

std::vector<Point> fanOfAxes(const Point& from, const Point& to, double angle, int count) {
  requireCount(count);
  require(std::isfinite(angle), "the angle is not finite");
  const Point u = unitVector(from), towards = unitVector(to);
  const Point v = unitVector(plus(towards, u, -dot(towards, u)));
  std::vector<Point> axes;
  for (int i = 0; i < count; ++i) {
    Point axis{};
    axes.push_back(plus(plus(axis, u, elementary::cos(angle * i)), v, elementary::sin(angle * i)));
  }
  return axes;
}

Root constantFactor(const Quaternion<double>& c) {
  const double length = elementary::hypot(elementary::hypot(c.a, c.b), elementary::hypot(c.c, c.d));
  require(length > 0 && std::isfinite(length), "a constant factor has no direction");
  return {c * (-kFar / length), 1};
}

void appendRings(std::vector<Root>& roots, const Point& point, const Point& axis, int power, int repeats,
                 const Embedding& embedding) {
  require(power != 0 && std::abs(power) <= kMostFactorPower,
          "the power is " + std::to_string(power) + "; it must be 1 to 1000, or -1 to -1000");
  require(repeats >= 1 && repeats <= kMostFactorPower,
          "the number of repetitions is " + std::to_string(repeats) + "; it must be 1 to 1000");
  const Quaternion<double> t = embedding.quaternion<double>(point);
  Embedding unsliced = embedding;
  unsliced.slice = 0;
  const Quaternion<double> n = unsliced.quaternion<double>(unitVector(axis));
  if (n == Quaternion<double>::one()) {
    roots.push_back({t, static_cast<double>(power) * repeats});
    return;
  }
  for (int i = 0; i < repeats; ++i) {
    roots.push_back({t, static_cast<double>(power)});
    roots.push_back(constantFactor(conjugate(n)));
  }
}

double unitConstants(const std::vector<Root>& roots) {
  double sum = 0;
  for (const Root& root : roots)
    if (isFar(root)) sum -= root.power * elementary::log(kFar);
  return sum;
}

}  // namespace julia
