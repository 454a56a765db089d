// SPDX-License-Identifier: Apache-2.0
// Bounds over balls: above everything that is read in them, and close to it.
#include "exponent/radial_bound.h"

#include "support/test_fields.h"

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/exponent/exponent_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <span>

namespace {

using namespace vdbtools;
using julia::Interpolation;
using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr double kLattice = 1.0 / 24;

/// E at the nodes of a lattice that contains [-0.7, 0.7]^3.
FloatGrid::Ptr gridOf(const test_fields::Distance& exponent, double voxel) {
  const int half = static_cast<int>(0.7 / voxel) + 1;
  return test_fields::denseGrid(exponent, voxel, {openvdb::Coord(-half), openvdb::Coord(half)});
}

/// What is read of a grid at a point.
class Read {
 public:
  Read(const FloatGrid::Ptr& grid, Interpolation interpolation) {
    ExponentGrid exponent;
    exponent.grid = grid;
    exponent.interpolation = interpolation;
    mField = makeExponentField<float>(exponent);
  }
  double operator()(const Vec3d& at) const {
    const float x = static_cast<float>(at[0]), y = static_cast<float>(at[1]), z = static_cast<float>(at[2]);
    float value = 0;
    mField->sample(std::span(&x, 1), std::span(&y, 1), std::span(&z, 1), std::span(&value, 1));
    return static_cast<double>(value);
  }

 private:
  std::shared_ptr<const julia::ScalarField<float>> mField;
};

/// The largest difference between neighbours along an axis.
double steepest(const FloatGrid& grid) {
  const auto at = grid.getConstAccessor();
  float most = 0;
  for (auto value = grid.cbeginValueOn(); value; ++value)
    for (int axis = 0; axis < 3; ++axis) {
      openvdb::Coord next = value.getCoord();
      ++next[axis];
      if (at.isValueOn(next)) most = std::max(most, std::abs(*value - at.getValue(next)));
    }
  return static_cast<double>(most);
}

julia::RadialMaximum boundOf(const FloatGrid& grid, const Vec3d& origin, Interpolation interpolation) {
  Monitor monitor;
  constexpr double kNothing = -std::numeric_limits<double>::infinity();
  const int steps = interpolation == Interpolation::Quadratic ? 9 : 3;
  return RadialBound(grid.tree(), grid.transform(), origin, 1, interpolation, kNothing, steps * steepest(grid), monitor)
      .maximum(kNothing, monitor);
}

Vec3d inBall(std::mt19937& random, double radius) {
  std::normal_distribution<double> normal;
  Vec3d direction(normal(random), normal(random), normal(random));
  direction.normalize();
  return direction * radius * std::cbrt(std::uniform_real_distribution<double>(0, 1)(random));
}

class BoundOverBalls : public testing::TestWithParam<Interpolation> {};

TEST_P(BoundOverBalls, NothingThatIsReadLiesAboveIt) {
  openvdb::initialize();
  std::mt19937 random(3);
  const auto noisy = [](const Vec3d& x) {
    return 2 * test_fields::lumpy(x) + 0.3 * test_fields::noise(openvdb::Coord::round(x / kLattice), 5) - 0.5;
  };
  // Those far from 0 are rounded more than their bounds.
  for (const double scale : {1.0, 1000.0})
    for (const bool isNoisy : {false, true})
      for (const Vec3d& origin : {Vec3d(0), Vec3d(0.05, -0.02, 0.01), Vec3d(0.3817, 0.1, 0.02)}) {
        const FloatGrid::Ptr exponent =
            gridOf([&](const Vec3d& x) { return scale * (isNoisy ? noisy(x) : 4 * test_fields::lumpy(x)); }, kLattice);
        const auto bound = boundOf(*exponent, origin, GetParam());
        const Read read(exponent, GetParam());
        double closest = 1e9;
        for (const double radius : {0.003, 0.02, 0.05, 0.1, 0.3})
          for (int i = 0; i < 4000; ++i) {
            const Vec3d offset = inBall(random, radius);
            const double above = bound.logBound(offset.length() * (1 - 1e-6)) - read(origin + offset);
            ASSERT_GE(above, 0) << offset << origin << isNoisy << scale;
            closest = std::min(closest, above);
          }
        EXPECT_LT(closest, 0.02 * steepest(*exponent)) << origin << isNoisy << scale;
      }
}

// The surface is 2.5 to 40 voxels away, and the bound gives away a small part of a voxel.
TEST_P(BoundOverBalls, IsAsTightAboutAThinPartAsAboutAThickOne) {
  openvdb::initialize();
  for (const double radius : {0.4, 0.1, 0.05, 0.025}) {
    const double voxel = 0.01, slope = 3;
    const auto sheet = [&](const Vec3d& x) { return slope * (std::abs(x[1] - 0.0023) - radius); };
    const auto bound = boundOf(*gridOf(sheet, voxel), Vec3d(0.001, 0.0023, -0.004), GetParam());
    for (double r = 0.4 * radius; r < 0.5; r += 0.001) {
      // Between nodes beside the middle of the sheet, what is read is above the distance.
      if (r < 2 * voxel) continue;
      EXPECT_NEAR(bound.logBound(r), slope * (r - radius), 0.05 * slope * voxel) << radius << ' ' << r;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Reads, BoundOverBalls, testing::Values(Interpolation::Trilinear, Interpolation::Quadratic));

TEST(RadialBound, ValuesThatAreNotKnownHaveTheGivenBound) {
  openvdb::initialize();
  const auto ball = [](const Vec3d& x) { return x.length() - 0.5; };
  const FloatGrid::Ptr whole = test_fields::bandGrid(ball, kLattice, 0.1),
                       hollow = test_fields::bandGrid(ball, kLattice, 0.1, 0.25);
  Monitor monitor;
  const auto boundWith = [&](const FloatGrid& grid, double inside) {
    return RadialBound(grid.tree(), grid.transform(), Vec3d(0), 1, Interpolation::Trilinear, inside,
                       3 * steepest(*whole), monitor)
        .maximum(inside, monitor);
  };
  const auto all = boundWith(*whole, -1), some = boundWith(*hollow, -0.25 + kLattice);
  for (double r = 0.01; r < 0.5; r += 0.01) {
    EXPECT_GE(some.logBound(r), all.logBound(r)) << r;
    if (r > 0.25 + 3 * kLattice) {
      EXPECT_EQ(some.logBound(r), all.logBound(r)) << r;
    }
  }
}

}  // namespace
