// SPDX-License-Identifier: Apache-2.0
// Charged conductors whose capacitance, charge and potential are known in closed form or to many digits.
#include "julia/fit/electrostatics.h"

#include "julia/fit/cancelled.h"
#include "support/fit_surfaces.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace {

using julia::ElectrostaticsOptions;
using julia::Point;
using julia::solveExteriorDirichlet;
using julia::SurfaceCharge;
using julia::TriangleSurface;
using law_tests::cube;
using law_tests::distance;
using law_tests::norm;
using law_tests::sphere;
using law_tests::stretched;
using std::numbers::pi;

constexpr double kCube = 0.66067815;  // Hwang & Mascagni, J. Appl. Phys. 95(7), 2004, and others since

using Triangle = std::array<Point, 3>;

Point mix(const Triangle& triangle, double a, double b, double c) {
  Point x;
  for (int axis = 0; axis < 3; ++axis) x[axis] = a * triangle[0][axis] + b * triangle[1][axis] + c * triangle[2][axis];
  return x;
}

double areaOf(const Triangle& t) { return julia::area({{t[0], t[1], t[2]}, {{0, 1, 2}}}); }

std::vector<double> potentials(const TriangleSurface& surface, const SurfaceCharge& charge,
                               const std::vector<Point>& x) {
  std::vector<double> p(x.size());
  julia::potential(surface, charge, x, p);
  return p;
}

/// The library's integral of 1 / |x - y| over a triangle: the potential of the density 1.
double integral(const Triangle& t, const Point& x) {
  return potentials({{t[0], t[1], t[2]}, {{0, 1, 2}}}, {{1}}, {x})[0];
}

/// The same by quartering triangles until the mean at seven inner points agrees with that of the parts.
double integralByQuartering(const Triangle& t, double wholeArea, const Point& x, double tolerance, int depth = 0) {
  const auto rule = [&](const Triangle& part) {
    const auto at = [&](double a, double b, double c) { return 1 / std::max(1e-300, distance(mix(part, a, b, c), x)); };
    double sum = 0.225 * at(1. / 3, 1. / 3, 1. / 3);
    for (const double sign : {-1., 1.}) {
      const double b = (6 + sign * std::sqrt(15.)) / 21;
      sum += (155 + sign * std::sqrt(15.)) / 1200 * (at(1 - 2 * b, b, b) + at(b, 1 - 2 * b, b) + at(b, b, 1 - 2 * b));
    }
    return sum;
  };
  const Point ab = mix(t, .5, .5, 0), bc = mix(t, 0, .5, .5), ca = mix(t, .5, 0, .5);
  const std::array<Triangle, 4> parts = {Triangle{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {bc, ca, ab}};
  double fine = 0;
  for (const Triangle& part : parts) fine += wholeArea / 4 * rule(part);
  if (depth > 2 && (std::abs(fine - wholeArea * rule(t)) < tolerance || depth > 35)) return fine;
  double sum = 0;
  for (const Triangle& part : parts) sum += integralByQuartering(part, wholeArea / 4, x, tolerance, depth + 1);
  return sum;
}

TEST(PanelIntegral, isThatOfBruteForce) {
  const Triangle even{{{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}};
  const Triangle tilted{{{3, 1, -2}, {3.5, 0.2, -1}, {2.1, 0.7, -1.4}}};
  const Triangle thin{{{0, 0, 0}, {0.4, 1, 0.2}, {0.41, 1.05, 0.22}}};
  for (const Triangle& t : {even, tilted, thin}) {
    const Point u{t[1][0] - t[0][0], t[1][1] - t[0][1], t[1][2] - t[0][2]};
    const Point v{t[2][0] - t[0][0], t[2][1] - t[0][1], t[2][2] - t[0][2]};
    const Point n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    // Barycentric places of the foot: inside, on an edge, at corners, on an edge's line, and outside.
    for (const Point& foot : {Point{0.21, 0.33, 0.46},
                              {0.37, 0.63, 0},
                              {0, 0.37, 0.63},
                              {1, 0, 0},
                              {0, 0, 1},
                              {-0.7, 1.7, 0},
                              {0.1, -0.4, 1.3},
                              {-1, 1, 1}})
      for (const double height : {0., 1e-12, 1e-4, 0.03, 0.5, 2., -2., 5., 11.}) {
        Point x = mix(t, foot[0], foot[1], foot[2]);
        for (int axis = 0; axis < 3; ++axis) x[axis] += height * n[axis] / norm(n);
        const double expected = integralByQuartering(t, areaOf(t), x, 1e-11 * areaOf(t));
        EXPECT_NEAR(integral(t, x) / expected, 1, 3e-7)
            << "foot " << foot[0] << ' ' << foot[1] << ' ' << foot[2] << ", height " << height;
      }
  }
}

// Closed forms for the right isosceles triangle with legs 1: from its right angle 2 ln(1 + sqrt 2) / sqrt 2; a square's
// centre sees four of them from there.
TEST(PanelIntegral, isThatOfClosedForms) {
  const double corner = std::numbers::sqrt2 * std::log(1 + std::numbers::sqrt2);
  EXPECT_NEAR(integral({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {0, 0, 0}), corner, 1e-14);
  EXPECT_NEAR(integral({{{7, 7, 9}, {7, 9, 9}, {7, 7, 11}}}, {7, 7, 9}), 2 * corner, 1e-13);
  // Very near the plane it is that in the plane, less 2 pi h.
  EXPECT_NEAR(integral({{{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}}, {0, 0, 1e-8}),
              integral({{{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}}, {0, 0, 0}) - 2 * pi * 1e-8, 1e-13);
}

TEST(PanelIntegral, doesNotDependOnOrientation) {
  const Triangle t{{{3, 1, -2}, {3.5, 0.2, -1}, {2.1, 0.7, -1.4}}};
  for (const Point& x : {Point{3, 1, -1.9}, {2.5, 0.7, -1.5}, {4, 4, 4}}) {
    EXPECT_NEAR(integral(t, x), integral({t[1], t[0], t[2]}, x), 1e-14);
    EXPECT_NEAR(integral(t, x), integral({t[2], t[0], t[1]}, x), 1e-14);
  }
}

// The sphere through the mesh's points is a little larger than the mesh, and the error falls with its gap: as the
// square of the edges.
TEST(Sphere, capacitanceIsTheRadius) {
  const double expected[] = {0.17, 0.05, 0.0131, 0.0034};
  for (int k = 0; k <= 3; ++k) {
    const SurfaceCharge charge = solveExteriorDirichlet(sphere(k));
    EXPECT_LT(charge.capacitance, 1) << k;
    EXPECT_GT(charge.capacitance, 1 - expected[k]) << k;
    EXPECT_LT(charge.residual, 1e-13) << k;
    EXPECT_EQ(charge.iterations, 0) << k;
  }
}

TEST(Sphere, chargeIsUniform) {
  const SurfaceCharge charge = solveExteriorDirichlet(sphere(3));
  const auto [least, most] = std::minmax_element(charge.density.begin(), charge.density.end());
  EXPECT_NEAR(*least * 4 * pi, 1, 0.01);
  EXPECT_NEAR(*most * 4 * pi, 1, 0.01);
}

TEST(Sphere, potentialIsOneOverR) {
  const TriangleSurface surface = sphere(3);
  const SurfaceCharge charge = solveExteriorDirichlet(surface);
  const Point direction{2. / 7, 3. / 7, -6. / 7};
  std::vector<Point> x;
  const std::vector<double> radii{0., 0.3, 0.9, 1.05, 1.2, 2, 10, 1000};
  for (const double r : radii) x.push_back({r * direction[0], r * direction[1], r * direction[2]});
  const std::vector<double> p = potentials(surface, charge, x);
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(p[i], radii[i] < 1 ? 1 : charge.capacitance / radii[i], 5e-4 / std::max(1., radii[i])) << radii[i];
}

TEST(Cube, capacitanceIsTheKnownOne) {
  // Charge is infinite along the edges. Meshes crowded there come near by themselves ...
  const double expected[] = {0.004, 0.0006, 0.0001};
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(solveExteriorDirichlet(cube(4U << k, 3)).capacitance, kCube, expected[k]) << k;
  // ... and even ones leave an error that falls by the same factor each time, which Aitken's formula takes out.
  std::array<double, 3> even{};
  for (int k = 0; k < 3; ++k) even[k] = solveExteriorDirichlet(cube(4U << k)).capacitance;
  const double first = even[1] - even[0], second = even[2] - even[1];
  EXPECT_GT(first / second, 2);
  EXPECT_NEAR(even[2] + second * second / (first - second), kCube, 0.0002);
}

/// An ellipsoid's density at x is C / (4 pi a b c) over the root of sum x_i^2 / a_i^4.
void expectEllipsoid(const Point& axes, double capacitance, double capacitanceError, double densityError) {
  const TriangleSurface surface = stretched(sphere(3), axes);
  const SurfaceCharge charge = solveExteriorDirichlet(surface);
  EXPECT_NEAR(charge.capacitance / capacitance, 1, capacitanceError);
  double worst = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    Point x = mix({surface.points[a], surface.points[b], surface.points[c]}, 1. / 3, 1. / 3, 1. / 3);
    const double out = norm({x[0] / axes[0], x[1] / axes[1], x[2] / axes[2]});
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) sum += std::pow(x[axis] / out / (axes[axis] * axes[axis]), 2);
    const double density = capacitance / (4 * pi * axes[0] * axes[1] * axes[2] * std::sqrt(sum));
    worst = std::max(worst, std::abs(charge.density[t] / density - 1));
  }
  EXPECT_LT(worst, densityError);
}

TEST(Spheroid, capacitanceAndDensityAreTheClosedForms) {
  {
    SCOPED_TRACE("prolate");
    const double focus = std::sqrt(8.);
    expectEllipsoid({1, 1, 3}, focus / std::atanh(focus / 3), 0.004, 0.05);
  }
  {
    SCOPED_TRACE("oblate");
    expectEllipsoid({3, 3, 1}, std::sqrt(8.) / std::acos(1. / 3), 0.004, 0.05);
  }
}

TEST(Conductor, scalesAndMoves) {
  const double unit = solveExteriorDirichlet(cube(4, 2)).capacitance;
  TriangleSurface surface = stretched(cube(4, 2), {0.125, 0.125, 0.125});
  for (Point& x : surface.points) x[0] += 30, x[2] -= 5;
  EXPECT_NEAR(solveExteriorDirichlet(surface).capacitance, unit / 8, 1e-7);
  EXPECT_NEAR(solveExteriorDirichlet(stretched(cube(4, 2), {1e-6, 1e-6, 1e-6})).capacitance / unit, 1e-6, 1e-14);
}

// A smaller conductor inside feels no field: it carries no charge.
TEST(Conductor, screens) {
  TriangleSurface surface = sphere(2);
  const std::size_t outer = surface.triangles.size();
  const double alone = solveExteriorDirichlet(surface).capacitance;
  const TriangleSurface inner = stretched(sphere(1), {0.4, 0.4, 0.4});
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  surface.points.insert(surface.points.end(), inner.points.begin(), inner.points.end());
  for (const auto& [a, b, c] : inner.triangles) surface.triangles.push_back({first + a, first + b, first + c});
  const SurfaceCharge charge = solveExteriorDirichlet(surface);
  EXPECT_NEAR(charge.capacitance, alone, 1e-4);
  for (std::size_t t = outer; t < surface.triangles.size(); ++t) EXPECT_NEAR(charge.density[t], 0, 0.002) << t;
}

TEST(Iteration, findsWhatTheDirectSolutionIs) {
  for (const TriangleSurface& surface : {cube(6, 2), stretched(sphere(2), {1, 2, 9})}) {
    ElectrostaticsOptions options;
    const SurfaceCharge direct = solveExteriorDirichlet(surface, options);
    options.maxDense = 0;
    options.tolerance = 1e-7;
    const SurfaceCharge iterated = solveExteriorDirichlet(surface, options);
    EXPECT_EQ(direct.iterations, 0);
    EXPECT_GT(iterated.iterations, 5);
    EXPECT_LE(iterated.residual, 1e-7);
    EXPECT_NEAR(iterated.capacitance / direct.capacitance, 1, 1e-7);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      EXPECT_NEAR(iterated.density[t] / direct.density[t], 1, 1e-5) << t;
  }
}

TEST(Iteration, memoryChangesNoBit) {
  const TriangleSurface surface = cube(6, 2);
  ElectrostaticsOptions options;
  options.maxDense = 0;
  const SurfaceCharge all = solveExteriorDirichlet(surface, options);
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1000}, 100 * surface.triangles.size()}) {
    options.maxStoredBytes = bytes;
    EXPECT_EQ(solveExteriorDirichlet(surface, options).density, all.density) << bytes;
  }
}

TEST(Electrostatics, threadsChangeNoBit) {
  const TriangleSurface surface = cube(7, 2);
  const std::vector<Point> x = sphere(2).points;
  for (const std::size_t maxDense : {0, 10000}) {
    ElectrostaticsOptions options;
    options.maxDense = maxDense;
    std::vector<double> density, outside;
    for (const std::size_t threads : {1, 2, 7}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      const SurfaceCharge charge = solveExteriorDirichlet(surface, options);
      if (density.empty()) density = charge.density, outside = potentials(surface, charge, x);
      EXPECT_EQ(charge.density, density) << threads;
      EXPECT_EQ(potentials(surface, charge, x), outside) << threads;
    }
  }
}

TEST(Electrostatics, poorTrianglesAreSurvived) {
  TriangleSurface surface = sphere(2);
  const SurfaceCharge good = solveExteriorDirichlet(surface);
  // Without area: left out.
  surface.triangles.push_back({0, 0, 5});
  surface.triangles.push_back({3, 3, 3});
  SurfaceCharge charge = solveExteriorDirichlet(surface);
  EXPECT_EQ(charge.capacitance, good.capacitance);
  EXPECT_EQ(charge.density.back(), 0);
  // Twice the same: they share the charge.
  surface.triangles.push_back(surface.triangles[17]);
  charge = solveExteriorDirichlet(surface);
  EXPECT_NEAR(charge.capacitance, good.capacitance, 1e-5);
  EXPECT_NEAR(charge.density.back() + charge.density[17], good.density[17], 1e-4);
}

TEST(Electrostatics, refusesNonsense) {
  const auto expectThrow = [](TriangleSurface surface, const ElectrostaticsOptions& options, const char* what) {
    EXPECT_THROW(solveExteriorDirichlet(surface, options), std::invalid_argument) << what;
  };
  const TriangleSurface good = sphere(1);
  expectThrow({}, {}, "nothing");
  expectThrow({good.points, {{1, 1, 2}}}, {}, "no area");
  TriangleSurface bad = good;
  bad.points[4][2] = std::numeric_limits<double>::quiet_NaN();
  expectThrow(bad, {}, "NaN");
  bad = good;
  bad.triangles[4][2] = 1000;
  expectThrow(bad, {}, "index");
  for (const double tolerance : {0., -1., 1e-9, 1., std::numeric_limits<double>::quiet_NaN()}) {
    ElectrostaticsOptions options;
    options.tolerance = tolerance;
    expectThrow(good, options, "tolerance");
  }
  ElectrostaticsOptions options;
  options.maxIterations = 0;
  expectThrow(good, options, "iterations");
  options.maxDense = 0;
  options.maxIterations = 3;
  expectThrow(cube(5), options, "too few iterations");

  const SurfaceCharge charge = solveExteriorDirichlet(good);
  std::vector<double> p(1);
  const auto at = [&](const TriangleSurface& surface, const std::vector<Point>& x) {
    julia::potential(surface, charge, x, p);
  };
  EXPECT_NO_THROW(at(good, {{1, 2, 3}}));
  EXPECT_THROW(at(sphere(0), {{1, 2, 3}}), std::invalid_argument);
  EXPECT_THROW(at(good, {{1, 2, 3}, {4, 5, 6}}), std::invalid_argument);
  EXPECT_THROW(at(good, {{1, std::numeric_limits<double>::infinity(), 3}}), std::invalid_argument);
}

TEST(Electrostatics, canBeCancelled) {
  for (const std::size_t maxDense : {0, 10000})
    for (const int after : {0, 3, 30}) {
      std::atomic<int> asked = 0;
      ElectrostaticsOptions options;
      options.maxDense = maxDense;
      options.cancelled = [&] { return asked++ >= after; };
      EXPECT_THROW(solveExteriorDirichlet(cube(8), options), julia::Cancelled) << maxDense << ' ' << after;
    }
}

}  // namespace
