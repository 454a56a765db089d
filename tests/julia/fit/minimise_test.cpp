// SPDX-License-Identifier: Apache-2.0
// The optimiser of the shape energy: it only goes down, keeps to the bounds, and finds what is known.
#include "julia/fit/minimise.h"

#include "julia/fit/cancelled.h"
#include "support/float128.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

namespace {

using julia::FitCell;
using julia::FitVariables;
using julia::minimise;
using julia::MinimiseOptions;
using julia::Point;
using julia::Polynomial;
using julia::Rational;
using julia::ShapeEnergy;
using law_tests::Random;
using law_tests::text;

/// A lattice of n^3 cells in [-1, 1]^3 about a ball of the radius.
std::vector<FitCell> cellsAboutBall(int n, double radius) {
  std::vector<FitCell> cells;
  const double h = 2.0 / n;
  for (int i = 0; i < n * n * n; ++i) {
    const Point x{-1 + h * (i % n + 0.5), -1 + h * (i / n % n + 0.5), -1 + h * (i / n / n + 0.5)};
    cells.push_back({x, static_cast<float>(std::hypot(x[0], x[1], x[2]) - radius), 1});
  }
  return cells;
}

std::vector<Point> placesOf(const std::vector<FitCell>& cells) {
  std::vector<Point> places;
  for (const FitCell& cell : cells) places.push_back(cell.x);
  return places;
}

ShapeEnergy ballEnergy(int n, double radius, const Rational& rational, const julia::ShapeEnergyOptions& options = {}) {
  const std::vector<FitCell> cells = cellsAboutBall(n, radius);
  return ShapeEnergy(placesOf(cells), cellWeights(cells, julia::CellWeights::InverseDistance, 2.0 / n), rational,
                     options);
}

/// Roots anywhere, powers from 0 to 3.
Rational randomRational(std::uint64_t seed, int tops, int bottoms) {
  Random random(seed);
  const auto polynomial = [&](int count) {
    Polynomial result;
    for (int i = 0; i < count; ++i)
      result.roots.push_back({{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), 0},
                              random.integer(0, 4) == 0 ? 0 : random.between(0, 3)});
    result.powerScale = random.between(0.2, 2);
    return result;
  };
  return {random.between(-2, 2), polynomial(tops), polynomial(bottoms)};
}

void expectNothingNegative(const Rational& rational) {
  for (const Polynomial* polynomial : {&rational.top, &rational.bottom}) {
    EXPECT_GE(polynomial->powerScale, 0) << text(rational);
    for (const julia::Root& root : polynomial->roots) EXPECT_GE(root.power, 0) << text(rational);
  }
}

TEST(Minimise, energiesFallAndPowersStayAboveZero) {
  int atBound = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    for (const FitVariables variables : {FitVariables::Coarse, FitVariables::Full}) {
      Rational rational = randomRational(seed, 4, seed % 3 == 0 ? 0 : 5);
      julia::ShapeEnergyOptions energyOptions;
      energyOptions.alpha = seed % 2 == 0 ? 1 : 5;
      energyOptions.powerPenalty = seed % 4 == 0 ? 1e-3 : 0;
      const ShapeEnergy energy = ballEnergy(12, 0.4 + 0.01 * static_cast<double>(seed), rational, energyOptions);
      const double start = energy.evaluate(rational, nullptr);
      double lowest = start;
      int steps = 0;
      MinimiseOptions options;
      options.maxIterations = 60;
      options.onStep = [&](double value, const Rational& at) {
        EXPECT_LE(value, lowest) << seed;
        EXPECT_EQ(value, energy.evaluate(at, nullptr)) << seed;
        expectNothingNegative(at);
        lowest = value;
        ++steps;
      };
      const double end = minimise(energy, rational, variables, options);
      EXPECT_GT(steps, 1) << seed;
      EXPECT_LT(end, start) << seed;
      EXPECT_EQ(end, lowest) << seed;
      EXPECT_EQ(end, energy.evaluate(rational, nullptr)) << seed;
      expectNothingNegative(rational);
      for (const Polynomial* polynomial : {&rational.top, &rational.bottom})
        for (const julia::Root& root : polynomial->roots) atBound += variables == FitVariables::Full && root.power == 0;
    }
  EXPECT_GT(atBound, 5);  // or the bounds were never tried
}

// Where nothing lies at a bound the slope is 0; at a bound it points out.
TEST(Minimise, endsWhereTheSlopeIsFlat) {
  Rational rational = randomRational(3, 3, 3);
  julia::ShapeEnergyOptions energyOptions;
  energyOptions.powerPenalty = 0.02;  // so that there is a minimum
  const ShapeEnergy energy = ballEnergy(10, 0.6, rational, energyOptions);
  julia::RationalGradient gradient;
  energy.evaluate(rational, &gradient);
  const double before = std::abs(gradient.logScale) + std::abs(gradient.topScale) + std::abs(gradient.bottomScale);
  MinimiseOptions options;
  options.tolerance = 1e-12;
  options.maxIterations = 5000;
  minimise(energy, rational, FitVariables::Full, options);
  energy.evaluate(rational, &gradient);
  const double flat = 1e-3 * before;
  EXPECT_NEAR(gradient.logScale, 0, flat);
  for (const auto& [polynomial, slopes] :
       {std::pair{&rational.top, &gradient.top}, std::pair{&rational.bottom, &gradient.bottom}})
    for (std::size_t i = 0; i < slopes->size(); ++i) {
      EXPECT_GT((*slopes)[i], -flat) << i << text(rational);
      if (polynomial->roots[i].power > 0) {
        EXPECT_LT((*slopes)[i], flat) << i << text(rational);
      }
    }
}

TEST(Minimise, coarseLeavesThePowersAlone) {
  const Rational start = randomRational(5, 4, 3);
  Rational rational = start;
  minimise(ballEnergy(12, 0.6, rational), rational, FitVariables::Coarse, {});
  ASSERT_EQ(rational.top.roots, start.top.roots);
  ASSERT_EQ(rational.bottom.roots, start.bottom.roots);
  EXPECT_NE(rational.logScale, start.logScale);
  EXPECT_NE(rational.top.powerScale, start.top.powerScale);
  EXPECT_NE(rational.bottom.powerScale, start.bottom.powerScale);
}

// |q|^(tau T) e^C is 1 on the sphere of radius r if C = -tau T ln r. The cells know r to a part of their width.
TEST(Minimise, findsASphere) {
  constexpr int n = 24;
  for (const FitVariables variables : {FitVariables::Coarse, FitVariables::Full})
    for (const double radius : {0.35, 0.6, 0.8})
      for (const double C : {-1., 2.}) {
        Rational rational{C, {{{{0, 0, 0, 0}, 1.5}}, 1}, {}};
        const double energy = minimise(ballEnergy(n, radius, rational), rational, variables, {});
        const double power = rational.top.powerScale * rational.top.roots[0].power;
        EXPECT_NEAR(std::exp(-rational.logScale / power), radius, 0.25 * 2 / n) << radius;
        EXPECT_LT(energy, -0.95) << radius;
        EXPECT_GT(power, 1.5) << radius;  // a steeper map is a better step
      }
}

TEST(Minimise, threadsChangeNoBit) {
  for (const FitVariables variables : {FitVariables::Coarse, FitVariables::Full}) {
    Rational expected = randomRational(6, 6, 5);
    const ShapeEnergy energy = ballEnergy(20, 0.6, expected);
    const Rational start = expected;
    MinimiseOptions options;
    options.maxIterations = 25;
    minimise(energy, expected, variables, options);
    for (const std::size_t threads : {1, 3}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      Rational again = start;
      minimise(energy, again, variables, options);
      EXPECT_EQ(again, expected) << threads;
    }
  }
}

TEST(Minimise, iterationsAreBounded) {
  const Rational start = randomRational(7, 4, 4);
  const ShapeEnergy energy = ballEnergy(12, 0.6, start);
  double before = energy.evaluate(start, nullptr);
  for (const int iterations : {0, 1, 4, 16}) {
    Rational rational = start;
    MinimiseOptions options;
    options.maxIterations = iterations;
    const double value = minimise(energy, rational, FitVariables::Full, options);
    if (iterations == 0) {
      EXPECT_EQ(rational, start);
      EXPECT_EQ(value, before);
    } else {
      EXPECT_LT(value, before) << iterations;
    }
    before = value;
  }
}

TEST(Minimise, canBeCancelled) {
  for (const int after : {0, 3}) {
    Rational rational = randomRational(8, 4, 4);
    const ShapeEnergy energy = ballEnergy(12, 0.6, rational);
    int asked = 0;
    MinimiseOptions options;
    options.cancelled = [&] { return asked++ == after; };
    EXPECT_THROW(minimise(energy, rational, FitVariables::Full, options), julia::Cancelled);
    EXPECT_EQ(asked, after + 1);
  }
}

TEST(Minimise, refusesNonsense) {
  const Rational good = randomRational(9, 3, 3);
  const ShapeEnergy energy = ballEnergy(8, 0.6, good);
  const auto refused = [&](auto&& change, const char* what) {
    Rational rational = good;
    MinimiseOptions options;
    change(rational, options);
    EXPECT_THROW(minimise(energy, rational, FitVariables::Full, options), std::invalid_argument) << what;
  };
  refused([](Rational& r, MinimiseOptions&) { r.top.roots[1].power = std::nan(""); }, "power");
  refused([](Rational& r, MinimiseOptions&) { r.logScale = std::numeric_limits<double>::infinity(); }, "C");
  refused([](Rational& r, MinimiseOptions&) { r.top.roots.pop_back(); }, "other roots");
  refused([](Rational&, MinimiseOptions& o) { o.maxIterations = -1; }, "iterations");
  refused([](Rational&, MinimiseOptions& o) { o.tolerance = -1; }, "tolerance");
  refused([](Rational&, MinimiseOptions& o) { o.tolerance = std::nan(""); }, "tolerance");
}

// What the caller throws from its own functions is the caller's.
TEST(Minimise, exceptionsOfTheCallerPass) {
  Rational rational = randomRational(10, 3, 3);
  const ShapeEnergy energy = ballEnergy(8, 0.6, rational);
  MinimiseOptions options;
  options.onStep = [](double, const Rational&) { throw std::length_error("the disk is full"); };
  EXPECT_THROW(minimise(energy, rational, FitVariables::Full, options), std::length_error);
}

/// A ball about a centre, by one root of power 3 that is somewhere else, with C for the radius.
struct OneRoot {
  static constexpr int n = 24;
  Point centre;
  double radius;
  Rational rational;
  ShapeEnergy energy;

  OneRoot(const Point& centre, double radius, const julia::Quaternion<double>& root)
      : centre(centre), radius(radius), rational{-3 * std::log(radius), {{{root, 3}}, 1}, {}}, energy([&] {
          std::vector<FitCell> cells = cellsAboutBall(n, 0);
          for (FitCell& cell : cells)
            cell.phi = static_cast<float>(
                std::hypot(cell.x[0] - centre[0], cell.x[1] - centre[1], cell.x[2] - centre[2]) - radius);
          return ShapeEnergy(placesOf(cells), cellWeights(cells, julia::CellWeights::InverseDistance, 2.0 / n),
                             rational, {});
        }()) {}
};

TEST(MoveRoots, aRootMovesToTheMiddle) {
  for (const Point& centre : {Point{0.1, -0.05, 0.2}, Point{-0.25, 0.1, 0}}) {
    OneRoot scene(centre, 0.5, {0, 0, 0, 0});
    const double before = scene.energy.evaluate(scene.rational, nullptr);
    const std::vector<double> reach{0.5};
    const double energy = julia::moveRoots(scene.energy, scene.rational, reach, {});
    const julia::Root& root = scene.rational.top.roots[0];
    // The cells know the centre to a part of their width.
    const double part = 0.25 * 2 / OneRoot::n;
    EXPECT_NEAR(root.position.a, centre[0], part);
    EXPECT_NEAR(root.position.b, centre[1], part);
    EXPECT_NEAR(root.position.c, centre[2], part);
    EXPECT_EQ(root.position.d, 0);
    EXPECT_EQ(root.power, 3);
    EXPECT_EQ(scene.rational.logScale, -3 * std::log(0.5));
    EXPECT_LT(energy, before);
    // The energy's roots are those of the rational.
    EXPECT_EQ(scene.energy.evaluate(scene.rational, nullptr), energy);
  }
}

TEST(MoveRoots, reachIsTheFarthest) {
  const julia::Quaternion<double> start{0.1, -0.2, 0, 0.05};
  for (const double reach : {0., 0.03}) {
    OneRoot scene({0.3, -0.2, 0}, 0.5, start);
    julia::moveRoots(scene.energy, scene.rational, std::vector<double>{reach}, {});
    const julia::Quaternion<double>& found = scene.rational.top.roots[0].position;
    EXPECT_NEAR(found.a, start.a + reach, 1e-12);
    EXPECT_LE(std::abs(found.b - start.b), reach + 1e-12);
    EXPECT_LE(std::abs(found.c - start.c), reach + 1e-12);
    EXPECT_EQ(found.d, start.d) << "it left its slice";
  }
}

// Promise: In each stage of a fit "the roots ..."
TEST(MoveRoots, energiesFallForManyRoots) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Rational rational = randomRational(seed, 4, 5);
    const Rational start = rational;
    ShapeEnergy energy = ballEnergy(12, 0.6, rational);
    double last = energy.evaluate(rational, nullptr);
    MinimiseOptions options;
    options.maxIterations = 20;
    options.onStep = [&](double value, const Rational& now) {
      EXPECT_LT(value, last) << text(now);
      last = value;
    };
    const double value = julia::moveRoots(energy, rational, std::vector<double>(9, 0.1), options);
    EXPECT_EQ(value, last);
    EXPECT_NE(rational, start);
    for (const auto side : {&Rational::top, &Rational::bottom})
      for (std::size_t j = 0; j < (start.*side).roots.size(); ++j)
        EXPECT_EQ((rational.*side).roots[j].power, (start.*side).roots[j].power);
    EXPECT_EQ(rational.logScale, start.logScale);
  }
}

TEST(MoveRoots, refusesNonsense) {
  Rational rational = randomRational(9, 3, 3);
  ShapeEnergy energy = ballEnergy(8, 0.6, rational);
  const auto refused = [&](const std::vector<double>& reach) {
    EXPECT_THROW(julia::moveRoots(energy, rational, reach, {}), std::invalid_argument);
  };
  refused(std::vector<double>(5, 0.1));
  refused({0.1, 0.1, 0.1, 0.1, 0.1, -1e-9});
  refused({0.1, 0.1, 0.1, 0.1, std::nan(""), 0.1});
  refused({0.1, 0.1, 0.1, 0.1, 0.1, std::numeric_limits<double>::infinity()});
  MinimiseOptions options;
  options.cancelled = [] { return true; };
  EXPECT_THROW(julia::moveRoots(energy, rational, std::vector<double>(6, 0.1), options), julia::Cancelled);
}

// Powers below 0 are taken as 0: the other side of the rational is not theirs.
TEST(Minimise, negativePowersBecomeZero) {
  Rational rational = randomRational(11, 3, 3);
  rational.top.roots[0].power = -2;
  const ShapeEnergy energy = ballEnergy(10, 0.6, rational);
  minimise(energy, rational, FitVariables::Full, {});
  expectNothingNegative(rational);
}

}  // namespace
