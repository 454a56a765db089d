// SPDX-License-Identifier: Apache-2.0
// Random polynomials: the same everywhere, and where they were asked for.
#include "julia/random_roots.h"

#include "support/float128.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace {

using julia::DropAxis;
using julia::Point;
using julia::Polynomial;
using julia::randomPolynomial;
using julia::RandomRootsOptions;
using julia::Root;
using julia::RootPlacement;
using law_tests::text;

double sphere(const Point& x) { return std::hypot(x[0], x[1], x[2]) - 0.4; }

Point pointOf(const Root& root) { return {root.position.a, root.position.b, root.position.c}; }

// mt19937_64 is fixed by the standard, and no other step leaves room: these are the numbers of every machine.
// Promise of design.md: "Every seed is in the recipe", and no library can change what it draws
TEST(RandomPolynomial, frozen) {
  RandomRootsOptions options;
  options.count = 3;
  const Polynomial polynomial = randomPolynomial(options);
  ASSERT_EQ(polynomial.roots.size(), 3U);
  EXPECT_EQ(polynomial.powerScale, 1);
  EXPECT_EQ(polynomial.roots[0].position,
            (julia::Quaternion<double>{-0x1.76e90a81125e6p-2, -0x1.7451b6bf739c2p-2, -0x1.8fa5c310a338p-5, 0}))
      << text(polynomial.roots[0].position);
  EXPECT_EQ(polynomial.roots[0].power, 0x1.18384c18a171ep+1);
  EXPECT_EQ(polynomial.roots[2].position,
            (julia::Quaternion<double>{0x1.1e180b364f46p-4, 0x1.14f41ae07224p-3, -0x1.a46661cb18046p-2, 0}))
      << text(polynomial.roots[2].position);
  EXPECT_EQ(polynomial.roots[2].power, 0x1.c05bea6e8699fp+2);
}

// Promise: "Every seed is in the recipe", and no library ...
// Promise of textures.md: "Every seed is another texture"
TEST(RandomPolynomial, seedDecides) {
  for (const RootPlacement placement :
       {RootPlacement::Box, RootPlacement::Inside, RootPlacement::Surface, RootPlacement::Cluster})
    for (const bool integers : {false, true}) {
      RandomRootsOptions options;
      options.placement = placement;
      options.integerPowers = integers;
      options.distance = sphere;
      options.count = 50;
      const Polynomial one = randomPolynomial(options);
      EXPECT_EQ(one, randomPolynomial(options));
      options.seed = 2;
      const Polynomial other = randomPolynomial(options);
      EXPECT_NE(one, other);
      for (std::size_t i = 0; i < 50; ++i) EXPECT_NE(one.roots[i].position, other.roots[i].position) << i;
    }
}

// More roots of one seed begin with the fewer ones.
TEST(RandomPolynomial, countOnlyAppends) {
  RandomRootsOptions options;
  options.count = 10;
  const Polynomial few = randomPolynomial(options);
  options.count = 25;
  Polynomial many = randomPolynomial(options);
  ASSERT_EQ(many.roots.size(), 25U);
  many.roots.resize(10);
  EXPECT_EQ(many, few);
}

TEST(RandomPolynomial, boxIsFilledEvenly) {
  RandomRootsOptions options;
  options.boxMin = {-1, 2, 5};
  options.boxMax = {3, 2.5, 5};
  options.count = 4000;
  const Polynomial polynomial = randomPolynomial(options);
  Point mean{};
  for (const Root& root : polynomial.roots) {
    const Point x = pointOf(root);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(x[axis], options.boxMin[axis]);
      ASSERT_LE(x[axis], options.boxMax[axis]);
      mean[axis] += x[axis] / options.count;
    }
    ASSERT_EQ(root.position.d, 0);
  }
  // The mean of N uniforms of width w has deviation w / sqrt(12 N); five of them.
  for (int axis = 0; axis < 3; ++axis) {
    const double width = options.boxMax[axis] - options.boxMin[axis];
    EXPECT_NEAR(mean[axis], (options.boxMin[axis] + options.boxMax[axis]) / 2,
                5 * width / std::sqrt(12. * options.count) + 1e-9)
        << axis;
  }
}

TEST(RandomPolynomial, insideIsInside) {
  RandomRootsOptions options;
  options.placement = RootPlacement::Inside;
  options.distance = sphere;
  options.count = 2000;
  int innerHalf = 0;
  for (const Root& root : randomPolynomial(options).roots) {
    ASSERT_LT(sphere(pointOf(root)), 0) << text(root.position);
    if (std::hypot(root.position.a, root.position.b, root.position.c) < 0.4 * std::cbrt(0.5)) ++innerHalf;
  }
  // Half of the volume holds half of them: deviation sqrt(N) / 2.
  EXPECT_NEAR(innerHalf, 1000, 5 * std::sqrt(2000.) / 2);
}

TEST(RandomPolynomial, surfaceIsNear) {
  RandomRootsOptions options;
  options.placement = RootPlacement::Surface;
  options.distance = sphere;
  // The sphere touches its box: what lies outside the target still is within the distance of it.
  options.boxMin = {-0.4, -0.4, -0.4};
  options.boxMax = {0.4, 0.4, 0.4};
  options.surfaceDistance = 0.02;
  options.count = 2000;
  int outside = 0, beyondBox = 0;
  for (const Root& root : randomPolynomial(options).roots) {
    const Point x = pointOf(root);
    ASSERT_LE(std::abs(sphere(x)), 0.02) << text(root.position);
    if (sphere(x) > 0) ++outside;
    if (std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}) > 0.4) ++beyondBox;
  }
  // Shells of 0.38 to 0.4 and of 0.4 to 0.42 have volumes 9.13 : 10.09 in thousandths; deviation sqrt(N) / 2.
  EXPECT_NEAR(outside, 2000 * 10.09 / 19.22, 5 * std::sqrt(2000.) / 2);
  EXPECT_GT(beyondBox, 0);
}

TEST(RandomPolynomial, clusterIsNormal) {
  RandomRootsOptions options;
  options.placement = RootPlacement::Cluster;
  options.clusterCentre = {1, -2, 3};
  options.clusterRadius = 0.5;
  options.count = 4000;
  const Polynomial polynomial = randomPolynomial(options);
  for (int axis = 0; axis < 3; ++axis) {
    double mean = 0, square = 0;
    int within = 0;
    for (const Root& root : polynomial.roots) {
      const double x = (pointOf(root)[axis] - options.clusterCentre[axis]) / options.clusterRadius;
      mean += x / options.count;
      square += x * x / options.count;
      if (std::abs(x) < 1) ++within;
    }
    const double deviation = 1 / std::sqrt(static_cast<double>(options.count));
    EXPECT_NEAR(mean, 0, 5 * deviation) << axis;
    // The variance of a square of a normal number is 2.
    EXPECT_NEAR(square, 1, 5 * std::sqrt(2.) * deviation) << axis;
    // Two thirds within one deviation: a sum of twelve uniforms has 67.9 %, a normal number 68.3 %.
    EXPECT_NEAR(within / 4000., 0.68, 5 * std::sqrt(0.68 * 0.32) * deviation + 0.003) << axis;
  }
}

TEST(RandomPolynomial, powersAreInTheirRange) {
  RandomRootsOptions options;
  options.count = 2000;
  options.minPower = -1.5;
  options.maxPower = 4.25;
  double least = 100, most = -100;
  for (const Root& root : randomPolynomial(options).roots) {
    least = std::min(least, root.power);
    most = std::max(most, root.power);
  }
  EXPECT_GE(least, -1.5);
  EXPECT_LE(most, 4.25);
  // That 2000 uniforms all miss the last hundredth has the chance 2e-9.
  EXPECT_LT(least, -1.5 + 0.0575);
  EXPECT_GT(most, 4.25 - 0.0575);
}

TEST(RandomPolynomial, integerPowersAreWholeAndReachBothEnds) {
  for (const auto& [low, high] : {std::pair{2., 11.}, {-2.5, 3.5}, {0., 0.}, {4.2, 5.1}, {-1e6, 1e6}}) {
    RandomRootsOptions options;
    options.integerPowers = true;
    options.minPower = low;
    options.maxPower = high;
    options.count = 2000;
    std::set<double> powers;
    for (const Root& root : randomPolynomial(options).roots) {
      ASSERT_EQ(root.power, std::round(root.power)) << low << ' ' << high;
      ASSERT_GE(root.power, low);
      ASSERT_LE(root.power, high);
      powers.insert(root.power);
    }
    if (high - low > 100) continue;
    EXPECT_EQ(static_cast<double>(powers.size()), std::floor(high) - std::ceil(low) + 1) << low << ' ' << high;
  }
}

TEST(RandomPolynomial, rootsLieInTheSlice) {
  RandomRootsOptions options;
  options.count = 20;
  const Polynomial plain = randomPolynomial(options);
  options.embedding.slice = 0.375;
  for (const DropAxis axis : {DropAxis::I, DropAxis::J, DropAxis::K}) {
    options.embedding.dropped = axis;
    const Polynomial sliced = randomPolynomial(options);
    for (std::size_t i = 0; i < sliced.roots.size(); ++i) {
      const auto& q = sliced.roots[i].position;
      const auto [x, y, z] = pointOf(plain.roots[i]);
      const julia::Quaternion<double> expected = axis == DropAxis::I   ? julia::Quaternion<double>{x, 0.375, y, z}
                                                 : axis == DropAxis::J ? julia::Quaternion<double>{x, y, 0.375, z}
                                                                       : julia::Quaternion<double>{x, y, z, 0.375};
      EXPECT_EQ(q, expected) << i;
      EXPECT_EQ(sliced.roots[i].power, plain.roots[i].power) << i;
    }
  }
}

TEST(RandomPolynomial, refusesNonsense) {
  const auto expectThrow = [](auto&& change, const char* what) {
    RandomRootsOptions options;
    options.distance = sphere;
    change(options);
    EXPECT_THROW(randomPolynomial(options), std::invalid_argument) << what;
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  expectThrow([](auto& o) { o.count = 0; }, "count 0");
  expectThrow([](auto& o) { o.count = -5; }, "count -5");
  expectThrow([](auto& o) { o.count = 1'000'000'000; }, "count 1e9");
  expectThrow([](auto& o) { o.minPower = 12; }, "powers reversed");
  expectThrow([](auto& o) { o.minPower = nan; }, "minPower NaN");
  expectThrow([](auto& o) { o.maxPower = infinity; }, "maxPower infinite");
  expectThrow([](auto& o) { o.integerPowers = true, o.minPower = 2.1, o.maxPower = 2.9; }, "no integer");
  expectThrow([](auto& o) { o.boxMin[1] = 1; }, "box reversed");
  expectThrow([](auto& o) { o.boxMax[2] = nan; }, "box NaN");
  expectThrow([](auto& o) { o.boxMin[0] = -infinity; }, "box infinite");
  expectThrow([](auto& o) { o.boxMin[0] = -1.7e308, o.boxMax[0] = 1.7e308; }, "box wider than a number");
  expectThrow([](auto& o) { o.embedding.slice = nan; }, "slice NaN");
  expectThrow([](auto& o) { o.embedding.slice = infinity; }, "slice infinite");
  for (const RootPlacement placement : {RootPlacement::Inside, RootPlacement::Surface})
    expectThrow([placement](auto& o) { o.placement = placement, o.distance = nullptr; }, "no target");
  for (const double bad : {0., -1., nan, infinity}) {
    expectThrow([bad](auto& o) { o.placement = RootPlacement::Surface, o.surfaceDistance = bad; }, "surface distance");
    expectThrow([bad](auto& o) { o.placement = RootPlacement::Cluster, o.clusterRadius = bad; }, "cluster radius");
  }
  for (const double bad : {nan, infinity})
    expectThrow([bad](auto& o) { o.placement = RootPlacement::Cluster, o.clusterCentre[1] = bad; }, "cluster centre");
  expectThrow([](auto& o) { o.placement = RootPlacement::Inside, o.distance = [](const Point&) { return 1.; }; },
              "nothing inside");
}

}  // namespace
