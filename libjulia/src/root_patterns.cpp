// SPDX-License-Identifier: Apache-2.0
#include "julia/root_patterns.h"

#include "number_text.h"
#include "random_numbers.h"
#include "require.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
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

Point crossProduct(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double squaredDistance(const Point& a, const Point& b) {
  const Point d = plus(a, b, -1);
  return dot(d, d);
}

Point unitVector(const Point& axis) {
  requireFinitePoint(axis, "the axis");
  const double length = elementary::hypot(axis[0], axis[1], axis[2]);
  require(length > 0 && std::isfinite(length), "the axis has no direction; give one of a length above 0");
  return {axis[0] / length, axis[1] / length, axis[2] / length};
}

/// Two unit vectors that form a right-handed frame with a third. The first lies towards a coordinate axis.
struct Frame {
  Point u, v;
};

Frame frameOf(const Point& axis) {
  // The coordinate axis that is most nearly perpendicular to this one.
  std::size_t least = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (std::abs(axis[i]) < std::abs(axis[least])) least = i;
  Point other{0, 0, 0};
  other[least] = 1;
  const Point u = unitVector(plus(other, axis, -dot(other, axis)));
  return {u, crossProduct(axis, u)};
}

/// Moves x to a nearby point of the surface by Newton steps along the gradient.
Point projected(Point x, const std::function<double(const Point&)>& distance, double step) {
  constexpr int kSteps = 4;
  for (int i = 0; i < kSteps; ++i) {
    Point gradient{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Point left = x, right = x;
      left[axis] -= step;
      right[axis] += step;
      gradient[axis] = (distance(right) - distance(left)) / (2 * step);
    }
    const double square = dot(gradient, gradient);
    if (!(square > 0)) return x;
    x = plus(x, gradient, -distance(x) / square);
  }
  return x;
}

/// Selects points that lie farthest from each other, beginning with the first.
std::vector<Point> spread(const std::vector<Point>& points, std::size_t count) {
  std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
  std::vector<Point> chosen;
  std::size_t next = 0;
  while (chosen.size() < count) {
    chosen.push_back(points[next]);
    for (std::size_t i = 0; i < points.size(); ++i)
      nearest[i] = std::min(nearest[i], squaredDistance(points[i], points[next]));
    next = static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
  }
  return chosen;
}

bool isFar(const Root& root) {
  // A root of a pattern is never as far away, and a constant factor that was scaled or moved is not a constant any
  // more.
  const Quaternion<double>& t = root.position;
  return elementary::hypot(elementary::hypot(t.a, t.b), elementary::hypot(t.c, t.d)) > kFar / 2;
}

}  // namespace

std::vector<Point> pointsOnLine(const Point& centre, const Point& axis, double length, int count) {
  return pointsOnHelix(centre, axis, 0, length, 0, count);
}

std::vector<Point> pointsOnCircle(const Point& centre, const Point& axis, double radius, int count) {
  return pointsOnHelix(centre, axis, radius, 0, 1, count);
}

std::vector<Point> pointsOnHelix(const Point& centre, const Point& axis, double radius, double length, double turns,
                                 int count) {
  requireCount(count);
  requireFinitePoint(centre, "the centre");
  requireFinitePoint({radius, length, turns}, "the radius, the length or the number of turns");
  const Point along = unitVector(axis);
  const Frame frame = frameOf(along);
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * turns * i / count;
    Point x = plus(centre, along, length * ((i + 0.5) / count - 0.5));
    x = plus(x, frame.u, radius * elementary::cos(angle));
    points.push_back(plus(x, frame.v, radius * elementary::sin(angle)));
  }
  return points;
}

std::vector<Point> pointsOfLattice(const Point& boxMin, const Point& boxMax, double spacing) {
  requireFinitePoint(boxMin, "the box");
  requireFinitePoint(boxMax, "the box");
  require(spacing > 0 && std::isfinite(spacing),
          "the lattice's spacing is " + textOf(spacing) + "; it must be above 0");
  std::array<int, 3> count{};
  double all = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require(boxMin[axis] <= boxMax[axis], "the box for the lattice is empty");
    const double nodes = std::max(1.0, std::floor((boxMax[axis] - boxMin[axis]) / spacing));
    all *= nodes;
    require(all <= kMostPoints, "the lattice has more than a million nodes; make its spacing larger");
    count[axis] = static_cast<int>(nodes);
  }
  const auto coordinate = [&](std::size_t axis, int i) {
    return (boxMin[axis] + boxMax[axis]) / 2 + spacing * (i - (count[axis] - 1) / 2.0);
  };
  std::vector<Point> points;
  for (int x = 0; x < count[0]; ++x)
    for (int y = 0; y < count[1]; ++y)
      for (int z = 0; z < count[2]; ++z) points.push_back({coordinate(0, x), coordinate(1, y), coordinate(2, z)});
  return points;
}

std::vector<Point> pointsOnSurface(const std::function<double(const Point&)>& distance, const Point& boxMin,
                                   const Point& boxMax, double reach, int count, std::uint64_t seed) {
  constexpr int kCandidatesEach = 40;  // enough for an even distribution
  constexpr int kTriesEach = 20'000;   // for a candidate; a surface that is thinner in its box counts as empty
  requireCount(count);
  require(distance != nullptr, "roots on a target's surface need the target; give one");
  require(reach > 0 && std::isfinite(reach), "the reach is " + textOf(reach) + "; it must be above 0");
  const auto wanted = static_cast<std::size_t>(count) * kCandidatesEach;
  Random random(seed);
  std::vector<Point> candidates;
  for (std::size_t tries = 0; candidates.size() < wanted && tries < wanted * kTriesEach; ++tries) {
    Point x;
    for (std::size_t axis = 0; axis < 3; ++axis) x[axis] = random.between(boxMin[axis], boxMax[axis]);
    if (std::abs(distance(x)) >= reach) continue;
    candidates.push_back(projected(x, distance, reach / 4));
  }
  require(!candidates.empty(), "no surface was found in the target's box");
  return spread(candidates, static_cast<std::size_t>(count));
}

std::vector<Point> jittered(std::vector<Point> points, double deviation, std::uint64_t seed) {
  require(std::isfinite(deviation), "the jitter is not finite");
  Random random(seed);
  for (Point& point : points)
    for (double& x : point) x += deviation * random.normal();
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
