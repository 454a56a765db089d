// SPDX-License-Identifier: Apache-2.0
// Directions and phases on surfaces whose answers are known.
#include "julia/grain/surface_graph.h"
#include "support/float128.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::DirectionWish;
using julia::Point;
using julia::SurfaceEdge;
using julia::SurfaceGraph;
using Complex = std::complex<double>;
using law_tests::Random;

constexpr double kTurn = 6.28318530717958647693;

double dotOf(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Points with their normals; neighbours are those within a distance whose normals are alike.
SurfaceGraph graphOf(std::vector<Point> positions, std::vector<Point> normals, double spacing) {
  std::vector<SurfaceEdge> edges;
  for (std::uint32_t i = 0; i < positions.size(); ++i)
    for (std::uint32_t j = 0; j < i; ++j) {
      const Point way{positions[i][0] - positions[j][0], positions[i][1] - positions[j][1],
                      positions[i][2] - positions[j][2]};
      if (dotOf(way, way) < 4 * spacing * spacing && dotOf(normals[i], normals[j]) > 0.3) edges.push_back({i, j});
    }
  const std::vector<double> spacings(positions.size(), spacing);
  return {std::move(positions), std::move(normals), spacings, std::move(edges)};
}

constexpr double kRing = 1, kTube = 0.35;

/// A torus about Z, at places that are shaken.
SurfaceGraph torus() {
  Random random(31);
  std::vector<Point> positions, normals;
  constexpr int kAround = 54, kAcross = 19;
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const double u = kTurn * (i + random.between(-0.2, 0.2)) / kAround;
      const double v = kTurn * (j + random.between(-0.2, 0.2)) / kAcross;
      const double r = kRing + kTube * std::cos(v);
      positions.push_back({r * std::cos(u), r * std::sin(u), kTube * std::sin(v)});
      normals.push_back({std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)});
    }
  return graphOf(std::move(positions), std::move(normals), 0.116);
}

/// The direction along the ring.
Point alongTorus(const Point& at) {
  const double r = std::hypot(at[0], at[1]);
  return {-at[1] / r, at[0] / r, 0};
}

double degreesBetween(const Point& a, const Point& b) {
  return std::acos(std::min(1., std::abs(dotOf(a, b)))) * 360 / kTurn;
}

// Promise: A grain: its table, `--grain-turn`, and that vectors ...
TEST(SurfaceGraphs, aTorusBendsLeastAlongItsRing) {
  const SurfaceGraph graph = torus();
  const std::vector<julia::Bending> bending = julia::bendings(graph, 1);
  double sum = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Point& at = graph.position(i);
    EXPECT_LT(degreesBetween(graph.vector(i, bending[i].least), alongTorus(at)), 12) << i;
    // The curvatures are 1 / tube and (1 - ring / r) / tube.
    const double r = std::hypot(at[0], at[1]), most = 1 / kTube, least = std::abs(1 - kRing / r) / kTube;
    EXPECT_NEAR(bending[i].difference, most - least, 0.35 * most) << i;
    sum += bending[i].difference / (most - least);
  }
  EXPECT_NEAR(sum / static_cast<double>(graph.size()), 1, 0.1);
}

TEST(SurfaceGraphs, theGradientOfALinearFunctionIsItsTangentialPart) {
  const SurfaceGraph graph = torus();
  const Point slope{0.3, -1.1, 0.7};
  std::vector<double> values;
  for (std::size_t i = 0; i < graph.size(); ++i) values.push_back(dotOf(slope, graph.position(i)));
  const std::vector<Complex> gradients = julia::gradients(graph, values);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Complex expected = graph.tangent(i, slope);
    EXPECT_LT(std::abs(gradients[i] - expected), 0.25) << i;
  }
}

/// A few wishes without a sign are enough: the field passes on their line and agrees on one sign.
// Promise: A grain: its table, `--grain-turn`, and that vectors ...
TEST(SurfaceGraphs, directionsFollowWishesSmoothly) {
  const SurfaceGraph graph = torus();
  std::vector<DirectionWish> wishes(graph.size());
  for (std::size_t i = 0; i < graph.size(); i += 7)
    wishes[i] = {graph.tangent(i, alongTorus(graph.position(i))) * (i % 2 ? 1. : -1.), 1, false};
  const std::vector<Complex> field = julia::smoothDirections(graph, wishes);
  int forward = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    EXPECT_NEAR(std::abs(field[i]), 1, 1e-12);
    const Point direction = graph.vector(i, field[i]);
    EXPECT_LT(degreesBetween(direction, alongTorus(graph.position(i))), 10) << i;
    forward += dotOf(direction, alongTorus(graph.position(i))) > 0;
  }
  EXPECT_TRUE(forward == 0 || forward == static_cast<int>(graph.size())) << forward;
}

// Promise: A grain: its table, `--grain-turn`, and that vectors ...
TEST(SurfaceGraphs, wishesWithASignKeepIt) {
  const SurfaceGraph graph = torus();
  std::vector<DirectionWish> wishes(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i)
    wishes[i] = {graph.tangent(i, alongTorus(graph.position(i))), 0.5, i % 50 == 0};
  const std::vector<Complex> field = julia::smoothDirections(graph, wishes);
  for (std::size_t i = 0; i < graph.size(); ++i)
    EXPECT_GT(dotOf(graph.vector(i, field[i]), alongTorus(graph.position(i))), 0.9) << i;
}

/// On a plane the phases are those of a plane wave; around a tube, a whole number of waves closes.
// Promise: Waves along a grain "are as long ..."
TEST(SurfaceGraphs, stripesAreWavesThatClose) {
  const SurfaceGraph graph = torus();
  constexpr double kWaves = 3.2;  // around the tube, which is no whole number
  std::vector<Complex> waves;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Point& n = graph.normal(i);
    const Point a = alongTorus(graph.position(i));
    const Point around{n[1] * a[2] - n[2] * a[1], n[2] * a[0] - n[0] * a[2], n[0] * a[1] - n[1] * a[0]};
    waves.push_back(graph.tangent(i, around) * (kWaves / kTube));
  }
  const std::vector<julia::SurfacePhase> phases = julia::stripePhases(graph, waves);
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const auto [from, to] = graph.edges()[e];
    EXPECT_NEAR(std::abs(phases[from].value), 1, 1e-12);
    // What the phase of one point says about the other.
    const Point &p = graph.position(from), &q = graph.position(to);
    const double turn = phases[from].gradient[0] * (q[0] - p[0]) + phases[from].gradient[1] * (q[1] - p[1]) +
                        phases[from].gradient[2] * (q[2] - p[2]);
    const Complex rest = phases[to].value * std::conj(phases[from].value * std::polar(1., turn));
    EXPECT_LT(std::abs(std::arg(rest)), 0.7) << e;
  }
  // Three waves around the tube.
  double sum = 0;
  for (const julia::SurfacePhase& phase : phases) sum += std::sqrt(dotOf(phase.gradient, phase.gradient)) * kTube;
  EXPECT_NEAR(sum / static_cast<double>(graph.size()), 3, 0.1);
}

TEST(SurfaceGraphs, theSameGraphGivesTheSameBits) {
  const SurfaceGraph graph = torus();
  std::vector<DirectionWish> wishes(graph.size());
  std::vector<Complex> waves(graph.size(), Complex(5, 2));
  wishes[3] = {1, 1, true};
  EXPECT_EQ(julia::smoothDirections(graph, wishes), julia::smoothDirections(graph, wishes));
  const auto one = julia::stripePhases(graph, waves), other = julia::stripePhases(graph, waves);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].value, other[i].value);
}

TEST(SurfaceGraphs, pointsWithoutNeighboursHaveAnAnswer) {
  const SurfaceGraph graph({{0, 0, 0}, {1, 0, 0}, {5, 5, 5}}, {{0, 0, 1}, {0, 0, 1}, {1, 0, 0}}, {1, 1, 1}, {{0, 1}});
  const std::vector<DirectionWish> wishes(3);
  for (const Complex& z : julia::smoothDirections(graph, wishes)) EXPECT_NEAR(std::abs(z), 1, 1e-12);
  for (const julia::SurfacePhase& phase : julia::stripePhases(graph, std::vector<Complex>(3, Complex(1, 0))))
    EXPECT_NEAR(std::abs(phase.value), 1, 1e-12);
  for (const julia::Bending& bending : julia::bendings(graph, 2)) EXPECT_TRUE(std::isfinite(bending.difference));
}

TEST(SurfaceGraphs, edgesWithoutPointsAreRefused) {
  const auto refuses = [](SurfaceEdge edge) {
    try {
      const SurfaceGraph graph({{0, 0, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, 0, 1}}, {1, 1}, {edge});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what()).find("two different points") != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refuses({0, 2}));
  EXPECT_TRUE(refuses({1, 1}));
}

}  // namespace
