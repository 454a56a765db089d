// SPDX-License-Identifier: Apache-2.0
// Monopoles: a least-squares fit at every step, of the columns that the greedy rule names.
#include "julia/fit/monopoles.h"

#include "julia/fit/cancelled.h"
#include "julia/fit/electrostatics.h"
#include "support/fit_surfaces.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

namespace {

using julia::fitMonopoles;
using julia::Monopole;
using julia::MonopoleFit;
using julia::MonopoleOptions;
using julia::Point;
using julia::Rational;
using julia::rationalFromMonopoles;
using julia::TriangleSurface;
using law_tests::cube;
using law_tests::distance;
using law_tests::norm;
using law_tests::sphere;
using law_tests::stretched;

struct PotentialTarget {
  TriangleSurface surface;
  std::vector<Point> samples;
  std::vector<double> potentials;
};

/// A unit sphere's own potential, a little outside.
PotentialTarget ballTarget() {
  PotentialTarget target{sphere(3), sphere(3).points, {}};
  for (Point& x : target.samples) {
    for (double& coordinate : x) coordinate *= 1.1;
    target.potentials.push_back(1 / norm(x));
  }
  return target;
}

/// A long box, whose potential needs boundary elements.
PotentialTarget boxTarget() {
  PotentialTarget target{stretched(cube(5, 2), {1, 2, 4}), {}, {}};
  target.samples = julia::blueNoise(stretched(cube(1), {1.2, 2.2, 4.2}), 900, 5);
  for (Point& x : target.samples)
    for (double& coordinate : x) coordinate -= 0.1;
  target.potentials.resize(target.samples.size());
  julia::potential(target.surface, julia::solveExteriorDirichlet(target.surface), target.samples, target.potentials);
  return target;
}

MonopoleFit monopoleFitOf(const PotentialTarget& target, const MonopoleOptions& options = {}) {
  return fitMonopoles(target.surface, target.samples, target.potentials, options);
}

std::vector<double> residualOf(const PotentialTarget& target, const std::vector<Monopole>& monopoles) {
  std::vector<double> residual;
  for (std::size_t i = 0; i < target.samples.size(); ++i) {
    double sum = target.potentials[i];
    for (const Monopole& monopole : monopoles) sum -= monopole.weight / distance(target.samples[i], monopole.position);
    residual.push_back(sum);
  }
  return residual;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// The weights of the same places from the normal equations, in 128 bits and by elimination.
std::vector<double> freshWeights(const PotentialTarget& target, const std::vector<Monopole>& monopoles) {
  using Wide = __float128;
  const std::size_t n = monopoles.size();
  std::vector<std::vector<Wide>> rows(n, std::vector<Wide>(n + 1));
  for (std::size_t i = 0; i < target.samples.size(); ++i) {
    std::vector<double> c;
    for (const Monopole& monopole : monopoles) c.push_back(1 / distance(target.samples[i], monopole.position));
    c.push_back(target.potentials[i]);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b <= n; ++b) rows[a][b] += Wide(c[a]) * c[b];
  }
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t a = 0; a < n; ++a) {
      const Wide factor = rows[a][k] / rows[k][k];
      for (std::size_t b = k; b <= n && a != k; ++b) rows[a][b] -= factor * rows[k][b];
    }
  std::vector<double> weights;
  for (std::size_t k = 0; k < n; ++k) weights.push_back(static_cast<double>(rows[k][n] / rows[k][k]));
  return weights;
}

TEST(Monopoles, residualsFallToEpsilon) {
  for (const PotentialTarget& target : {ballTarget(), boxTarget()})
    for (const double epsilon : {0.2, 0.04, 0.01}) {
      MonopoleOptions options;
      options.epsilon = epsilon;
      const MonopoleFit result = monopoleFitOf(target, options);
      ASSERT_EQ(result.residuals.size(), result.monopoles.size());
      double before = 1;
      for (const double residual : result.residuals) {
        EXPECT_GT(before, epsilon);
        EXPECT_LT(residual, before);
        before = residual;
      }
      EXPECT_LE(before, epsilon);
      const std::vector<double> r = residualOf(target, result.monopoles);
      EXPECT_NEAR(std::sqrt(dot(r, r) / dot(target.potentials, target.potentials)), before, 1e-12);
    }
}

TEST(Monopoles, weightsAreThoseOfAFreshSolution) {
  const PotentialTarget target = boxTarget();
  MonopoleOptions options;
  options.epsilon = 1e-3;
  options.maxCount = 60;
  const MonopoleFit result = monopoleFitOf(target, options);
  ASSERT_GT(result.monopoles.size(), 30U);
  const std::vector<double> expected = freshWeights(target, result.monopoles);
  double largest = 0;
  for (const double weight : expected) largest = std::max(largest, std::abs(weight));
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(result.monopoles[i].weight, expected[i], 1e-9 * largest) << i;
}

// The residual after fewer steps is that of the fewer: what is added later moves no place found before.
TEST(Monopoles, stepsAppend) {
  const PotentialTarget target = ballTarget();
  MonopoleOptions options;
  options.epsilon = 1e-3;
  options.maxCount = 20;
  const MonopoleFit many = monopoleFitOf(target, options);
  options.maxCount = 7;
  const MonopoleFit few = monopoleFitOf(target, options);
  ASSERT_EQ(many.monopoles.size(), 20U);
  ASSERT_EQ(few.monopoles.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(few.monopoles[i].position, many.monopoles[i].position) << i;
    EXPECT_EQ(few.residuals[i], many.residuals[i]) << i;
  }
}

TEST(Monopoles, aSphereNeedsFew) {
  const MonopoleFit result = monopoleFitOf(ballTarget());
  EXPECT_LT(result.monopoles.size(), 100U);
  // Their weights add up to the charge, seen from outside.
  double charge = 0;
  for (const Monopole& monopole : result.monopoles) {
    EXPECT_NEAR(norm(monopole.position), 1, 0.02);
    charge += monopole.weight;
  }
  EXPECT_NEAR(charge, 1, 0.04);
}

/// Specks of surface: candidates can lie in these places only.
TriangleSurface specks(const std::vector<Point>& places, double size) {
  TriangleSurface surface;
  for (const Point& x : places) {
    const auto first = static_cast<std::uint32_t>(surface.points.size());
    surface.points.push_back(x);
    surface.points.push_back({x[0] + size, x[1], x[2]});
    surface.points.push_back({x[0], x[1] + size, x[2]});
    surface.triangles.push_back({first, first + 1, first + 2});
  }
  return surface;
}

// Columns from within one speck are the same but for rounding; none is taken twice.
TEST(Monopoles, findsThoseThatAreThere) {
  const std::vector<Monopole> truth{{{0.5, 0, 0}, 1}, {{-0.5, 0.1, 0}, -0.75}, {{0, -0.3, 0.4}, 2.5}};
  PotentialTarget target;
  std::vector<Point> places;
  for (const Monopole& monopole : truth) places.push_back(monopole.position);
  places.push_back({0.1, 0.2, 0.3});  // nothing is there
  target.surface = specks(places, 1e-9);
  target.samples = sphere(2).points;
  target.potentials.assign(target.samples.size(), 0);
  std::vector<double> none = residualOf(target, truth);
  for (std::size_t i = 0; i < none.size(); ++i) target.potentials[i] = -none[i];

  MonopoleOptions options;
  options.epsilon = 1e-12;
  const MonopoleFit result = monopoleFitOf(target, options);
  ASSERT_LE(result.monopoles.size(), 4U);
  EXPECT_LT(result.residuals.back(), 1e-8);
  for (std::size_t place = 0; place < places.size(); ++place) {
    double weight = 0;
    for (const Monopole& monopole : result.monopoles)
      if (distance(monopole.position, places[place]) < 1e-8) weight += monopole.weight;
    EXPECT_NEAR(weight, place < truth.size() ? truth[place].weight : 0, 1e-6) << place;
  }
}

// A ring at distance 1 of one speck is matched by it alone; but the other is so near one sample that its column is
// longer than all of it.
TEST(Monopoles, columnsAreNotNormalised) {
  PotentialTarget target;
  target.surface = specks({{0, 0, 0}, {1.01, 0, 0}}, 1e-6);
  for (int i = 0; i < 10; ++i) target.samples.push_back({std::cos(0.6 * i), std::sin(0.6 * i), 0});
  target.potentials.assign(10, 1);
  MonopoleOptions options;
  options.epsilon = 0.001;
  const MonopoleFit result = monopoleFitOf(target, options);
  ASSERT_GE(result.monopoles.size(), 2U);
  EXPECT_NEAR(result.monopoles[0].position[0], 1.01, 1e-5);
  EXPECT_GT(result.residuals[0], 0.5);
}

// A candidate on a sample would be infinite, here and there.
TEST(Monopoles, samplesOnTheSurfaceAreSurvived) {
  PotentialTarget target{specks({{0, 0, 0}, {1, 0, 0}}, 1e-320), {{0, 0, 0}, {0, 2, 0}, {3, 3, 3}}, {1, 2, 3}};
  target.surface.triangles.push_back({0, 3, 4});
  target.surface.points[4] = {0.5, 1e-200, 1e-12};
  const MonopoleFit result = monopoleFitOf(target);
  for (const Monopole& monopole : result.monopoles) EXPECT_TRUE(std::isfinite(monopole.weight));
}

TEST(Monopoles, seedDecidesAndThreadsDoNot) {
  const PotentialTarget target = boxTarget();
  MonopoleOptions options;
  const MonopoleFit one = monopoleFitOf(target, options);
  for (const std::size_t threads : {1, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const MonopoleFit again = monopoleFitOf(target, options);
    EXPECT_EQ(again.monopoles, one.monopoles) << threads;
    EXPECT_EQ(again.residuals, one.residuals) << threads;
  }
  options.seed = 2;
  EXPECT_NE(monopoleFitOf(target, options).monopoles, one.monopoles);
}

// A pool holds 10000 candidates; steps of 4000 use up several.
TEST(Monopoles, poolsAreDrawnAnew) {
  const PotentialTarget target = ballTarget();
  for (const std::size_t candidates : {1, 4000, 15000}) {
    MonopoleOptions options;
    options.candidatesPerStep = candidates;
    options.maxCount = 3;
    const MonopoleFit result = monopoleFitOf(target, options);
    EXPECT_EQ(result.monopoles.size(), 3U);
    for (std::size_t i = 0; i < result.monopoles.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GT(distance(result.monopoles[i].position, result.monopoles[j].position), 0.01) << candidates;
  }
}

TEST(Monopoles, refusesNonsense) {
  const auto expectThrow = [](const std::function<void(PotentialTarget&, MonopoleOptions&)>& change, const char* what) {
    PotentialTarget target = ballTarget();
    MonopoleOptions options;
    change(target, options);
    EXPECT_THROW(monopoleFitOf(target, options), std::invalid_argument) << what;
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0., 1., -0.1, 2., nan}) expectThrow([bad](auto&, auto& o) { o.epsilon = bad; }, "epsilon");
  expectThrow([](auto&, auto& o) { o.maxCount = 0; }, "maxCount");
  expectThrow([](auto&, auto& o) { o.candidatesPerStep = 0; }, "candidates");
  expectThrow([](auto&, auto& o) { o.candidatesPerStep = 1U << 30; }, "candidates");
  expectThrow([](auto& t, auto&) { t.samples.pop_back(); }, "sizes");
  expectThrow([](auto& t, auto&) { t.samples.clear(), t.potentials.clear(); }, "nothing");
  expectThrow([](auto& t, auto&) { t.samples[3][1] = nan; }, "sample");
  expectThrow([](auto& t, auto&) { t.potentials[3] = 1e300; }, "potential");
  expectThrow([](auto& t, auto&) { t.potentials.assign(t.potentials.size(), 0); }, "zero");
  expectThrow([](auto& t, auto&) { t.surface.triangles.clear(); }, "no surface");
}

TEST(Monopoles, canBeCancelled) {
  int asked = 0;
  MonopoleOptions options;
  options.cancelled = [&] { return asked++ == 3; };
  EXPECT_THROW(monopoleFitOf(ballTarget(), options), julia::Cancelled);
}

TEST(RationalFromMonopoles, signsDecideTheSide) {
  const std::vector<Monopole> monopoles{{{1, 2, 3}, 0.5}, {{4, 5, 6}, -0.25}, {{7, 8, 9}, 0}, {{-1, 0, 1}, 2}};
  const Rational plain = rationalFromMonopoles(monopoles, 3000, false);
  EXPECT_EQ(plain.logScale, 0);
  EXPECT_EQ(plain.top.roots, (std::vector<julia::Root>{{{1, 2, 3, 0}, 1500}, {{-1, 0, 1, 0}, 6000}}));
  EXPECT_EQ(plain.bottom.roots, (std::vector<julia::Root>{{{4, 5, 6, 0}, 750}}));
  const Rational held = rationalFromMonopoles(monopoles, 3000, true);
  for (const auto side : {&Rational::top, &Rational::bottom}) {
    ASSERT_EQ((held.*side).roots.size(), (plain.*side).roots.size() + 1);
    EXPECT_EQ((held.*side).roots[0], (julia::Root{{0, 0, 0, 0}, 1}));
    EXPECT_EQ((held.*side).powerScale, 1);
  }
}

TEST(RationalFromMonopoles, refusesNonsense) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Monopole> good{{{1, 2, 3}, 0.5}};
  for (const double bad : {0., -1., nan, 1e10})
    EXPECT_THROW(rationalFromMonopoles(good, bad, false), std::invalid_argument) << bad;
  for (const Monopole& bad : {Monopole{{1, nan, 3}, 1}, {{1, 2, 3}, nan}, {{1, 2, 3}, 1e300}})
    EXPECT_THROW(rationalFromMonopoles({&bad, 1}, 1e8, false), std::invalid_argument);
}

}  // namespace
