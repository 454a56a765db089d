// SPDX-License-Identifier: Apache-2.0
// The target and its exponent: read as it is, widened without touching its band, clamped only where nothing depends on
// it.
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/exponent/exponent_grid.h"

#include <gtest/gtest.h>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::Vec3d;

constexpr double kTargetVoxel = 1.0 / 32;

double ball(const Vec3d& x) { return x.length() - 0.5; }

TEST(FractalSpace, TheBoxOfABallIsFoundBetweenNodes) {
  openvdb::initialize();
  for (const double radius : {0.31, 0.5, 0.517}) {
    const auto phi = test_fields::bandGrid([&](const Vec3d& x) { return x.length() - radius; }, kTargetVoxel, 0.2);
    const BBoxd box = insideBox(*phi);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(box.min()[axis], -radius, 1e-6) << radius;
      EXPECT_NEAR(box.max()[axis], radius, 1e-6) << radius;
    }
  }
}

TEST(FractalSpace, ACentreOutsideMovesToTheDeepestNode) {
  // A ring: its box's centre is a hole.
  const auto ring = [](const Vec3d& x) { return std::hypot(std::hypot(x[0], x[2]) - 0.35, x[1]) - 0.12; };
  const auto phi = test_fields::bandGrid(ring, kTargetVoxel, 0.2);
  const BBoxd box = insideBox(*phi);
  EXPECT_NEAR(box.extents()[0], 0.94, 1e-3);
  const FractalSpace space = fitFractalSpace(*phi, box);
  EXPECT_NEAR(space.scale, box.extents()[0], 1e-12);
  EXPECT_LT(ring(space.centre), -0.12 + 2 * kTargetVoxel);
  const Vec3d x(0.3, -1.2, 5);
  EXPECT_NEAR((space.toWorld(space.toFractal(x)) - x).length(), 0, 1e-12);
}

TEST(FractalSpace, ACentreInsideStays) {
  const auto phi = test_fields::bandGrid(ball, kTargetVoxel, 0.2);
  EXPECT_NEAR(fitFractalSpace(*phi, insideBox(*phi)).centre.length(), 0, 1e-6);
}

TEST(Target, RefusesWhatIsNoDistance) {
  const auto empty = openvdb::FloatGrid::create(1);
  EXPECT_THROW(makeTarget(empty, {}), DataError);
  const auto positive = test_fields::denseGrid([](const Vec3d&) { return 1.0; }, 0.1, {Coord(0), Coord(4)});
  EXPECT_THROW(makeTarget(positive, {}), DataError);
  const auto broken = test_fields::denseGrid(ball, 0.1, {Coord(-8), Coord(8)});
  broken->tree().setValue(Coord(1, 2, 3), std::nanf(""));
  EXPECT_THROW(makeTarget(broken, {}), DataError);
  const auto noOutside = test_fields::bandGrid(ball, kTargetVoxel, 0.1);
  noOutside->tree().root().setBackground(-1, false);
  EXPECT_THROW(makeTarget(noOutside, {}), DataError);
}

TEST(Target, TilesWithoutAnInsideTakeNoMemory) {
  const auto tiles = openvdb::FloatGrid::create(1);
  tiles->tree().addTile(1, Coord(0), 1.0f, true);
  tiles->tree().addTile(1, Coord(8000), 1.0f, true);
  EXPECT_THROW(makeTarget(tiles, {}), DataError);
  EXPECT_EQ(tiles->tree().leafCount(), 0U);
}

TEST(ExtendBand, KeepsTheBandAndFindsTheDistanceBeyond) {
  // Three voxels to each side, as level sets come.
  const auto phi = test_fields::bandGrid(ball, kTargetVoxel, 3 * kTargetVoxel, 3 * kTargetVoxel);
  Target target = makeTarget(phi->deepCopy(), {});
  Monitor monitor;
  const double width = 0.3;
  extendBand(target, width, std::numeric_limits<double>::infinity(), monitor);
  for (auto value = phi->cbeginValueOn(); value; ++value)
    ASSERT_EQ(target.phi->tree().getValue(value.getCoord()), *value) << value.getCoord();
  // Beyond, first-order sweeping: an error of some per cent of a voxel for each voxel of distance.
  std::size_t checked = 0;
  for (auto node = openvdb::CoordBBox(Coord(-26), Coord(26)).begin(); node; ++node) {
    const double distance = ball(phi->indexToWorld(*node));
    if (distance > width) continue;
    ++checked;
    ASSERT_TRUE(target.phi->tree().isValueOn(*node)) << *node << " at distance " << distance;
    ASSERT_NEAR(target.phi->tree().getValue(*node), distance, 0.5 * kTargetVoxel + 0.06 * std::abs(distance)) << *node;
  }
  EXPECT_GT(checked, 10000u);
}

TEST(ExtendBand, LeavesADenseTargetAlone) {
  const auto phi = test_fields::denseGrid([](const Vec3d& x) { return 3 * ball(x); }, 0.1, {Coord(-8), Coord(8)});
  Target target = makeTarget(phi, {});
  ASSERT_TRUE(target.denseBox.has_value());
  Monitor monitor;
  extendBand(target, 10, 10, monitor);
  EXPECT_EQ(target.phi, phi);
}

TEST(ExponentGrid, IsAlphaTimesPhiLessBetaWhereItMatters) {
  const auto phi = test_fields::bandGrid(ball, kTargetVoxel, 0.4);
  const Target target = makeTarget(phi, {});
  Monitor monitor;
  ExponentGridOptions options{.alpha = 40.0, .beta = 0.02, .orbit = {3, 20}};
  const ExponentGrid exponent = exponentGrid(target, FractalSpace{Vec3d(0), 2}, options, monitor);
  const double upper = std::log(20.0);
  EXPECT_DOUBLE_EQ(exponent.shell.upper, upper);
  EXPECT_LT(exponent.shell.lower, 0);
  const auto field = makeExponentField<double>(exponent);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.6, 0.6);
  int undecided = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    double read = 0;
    field->sample(std::span(&x, 1), std::span(&y, 1), std::span(&z, 1), std::span(&read, 1));
    // Fractal units are twice the world's here.
    const auto nodeExponent = [](const Vec3d& w) { return 40 * (static_cast<float>(ball(w)) / 2.0 - 0.02); };
    const double expected = test_fields::trilinear(nodeExponent, kTargetVoxel, Vec3d(x, y, z) * 2.0);
    ASSERT_EQ(read >= upper, expected >= upper) << x << " " << y << " " << z;
    ASSERT_EQ(read <= exponent.shell.lower, expected <= exponent.shell.lower) << x << " " << y << " " << z;
    if (expected <= exponent.shell.lower || expected >= upper) continue;
    ++undecided;
    ASSERT_NEAR(read, expected, 1e-5) << x << " " << y << " " << z;
  }
  EXPECT_GT(undecided, 300);
}

TEST(ExponentGrid, BeyondADenseFieldItsNearestFaceHolds) {
  const auto phi = test_fields::denseGrid(ball, 0.1, {Coord(-6), Coord(6)});
  const Target target = makeTarget(phi, {});
  Monitor monitor;
  const ExponentGrid exponent = exponentGrid(target, {}, {.alpha = 4.0, .beta = 0.0, .orbit = {3, 20}}, monitor);
  const auto field = makeExponentField<double>(exponent);
  const double x[4] = {0.6, 0.9, 15, -3}, y[4] = {0.3, 0.3, 0.3, -0.61}, z[4] = {0, 0, 0, 19};
  double read[4];
  field->sample(x, y, z, read);
  EXPECT_EQ(read[1], read[0]);
  EXPECT_EQ(read[2], read[0]);
  EXPECT_NEAR(read[3], 4 * ball(Vec3d(-0.6, -0.6, 0.6)), 1e-5);
}

TEST(ExponentGrid, AnInsideThatIsKnownInPartServesWhereItIsDeepEnough) {
  // The same distances, once over the whole inside and once to a depth: where that is said to be enough, E and its trap
  // are the same wherever an orbit goes on.
  Monitor monitor;
  const ExponentGridOptions options{.alpha = 20.0, .beta = 0.0, .orbit = {3, 20}};
  const auto exponentOf = [&](double depth) {
    return exponentGrid(makeTarget(test_fields::bandGrid(ball, 1.0 / 64, 0.3, depth), {}), {}, options, monitor);
  };
  const ExponentGrid whole = exponentOf(1e9);
  EXPECT_FALSE(whole.tooShallow);
  int enough = 0, tooLittle = 0;
  for (const double depth : {0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4}) {
    const ExponentGrid part = exponentOf(depth);
    (part.tooShallow ? tooLittle : enough) += 1;
    if (part.tooShallow) continue;
    EXPECT_EQ(part.shell.lower, whole.shell.lower) << depth;
    const auto a = makeExponentField<double>(part), b = makeExponentField<double>(whole);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-0.6, 0.6);
    for (int i = 0; i < 20000; ++i) {
      const double x = place(random), y = place(random), z = place(random);
      double readA = 0, readB = 0;
      a->sample(std::span(&x, 1), std::span(&y, 1), std::span(&z, 1), std::span(&readA, 1));
      b->sample(std::span(&x, 1), std::span(&y, 1), std::span(&z, 1), std::span(&readB, 1));
      ASSERT_EQ(readA <= whole.shell.lower, readB <= whole.shell.lower) << depth;
      if (readB > whole.shell.lower) {
        ASSERT_EQ(readA, readB) << depth;
      }
    }
  }
  EXPECT_GT(enough, 0);
  EXPECT_GT(tooLittle, 0);
}

TEST(ExponentGrid, TheTrappedBallIsThatOfTheRadialMaximum) {
  // E of a ball about the origin depends on |x| alone: m(r) = exp(alpha (r - R)), so r_in solves m(m(r)) = 1, m(r) = R.
  const double alpha = 20, radius = 0.5;
  const auto phi = test_fields::bandGrid(ball, 1.0 / 128, 0.3);
  Monitor monitor;
  const ExponentGrid exponent =
      exponentGrid(makeTarget(phi, {}), {}, {.alpha = alpha, .beta = 0.0, .orbit = {3, 20}}, monitor);
  const double exact = std::log(radius + std::log(radius) / alpha);
  EXPECT_LE(exponent.shell.lower, exact + 1e-9) << "not a bound";
  // The bound gives away two cell diagonals of 1/128 at most, in each of two applications.
  EXPECT_NEAR(exponent.shell.lower, exact, 2 * 2 * std::sqrt(3.0) / 128 / std::exp(exact));
}

// The plunge of a deep shell is thinner than a cell here: at nodes alone it could not be seen.
TEST(ExponentGrid, ADeepShellPlungesAtThePointThatIsRead) {
  const auto phi = test_fields::bandGrid(ball, kTargetVoxel, 0.4, 1e9);
  Monitor monitor;
  ExponentGridOptions options{.orbit = {3, 20}};
  const double detail = 0.8, outward = 0.2, tau = 0.5;
  options.detail = DetailOptions{.detail = detail, .outward = outward, .thickness = tau, .greatestThickness = tau};
  const ExponentGrid exponent = exponentGrid(makeTarget(phi, {}), {}, options, monitor);
  ASSERT_GT(exponent.knee.more, 1);
  const double h = 0.96 * tau, outside = (outward / (outward + detail) - 0.02) / 0.96, escape = std::log(20.0);
  ASSERT_LT(0.05 * h, kTargetVoxel);
  const auto field = makeExponentField<double>(exponent);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.6, 0.6);
  int plunging = 0, decided = 0;
  for (int i = 0; i < 60000; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    double read = 0;
    field->sample(std::span(&x, 1), std::span(&y, 1), std::span(&z, 1), std::span(&read, 1));
    const auto node = [](const Vec3d& at) { return static_cast<float>(ball(at)); };
    const double w = test_fields::trilinear(node, kTargetVoxel, {x, y, z}) / h - outside;
    const double v = escape + *exponent.scale * w,
                 expected = v + exponent.knee.more * std::min(v - exponent.knee.at, 0.0);
    if (w <= -1) {
      ASSERT_LE(read, exponent.shell.lower) << w;
    }
    if (w >= 0) {
      ASSERT_GE(read, escape - 1e-6) << w;
    }
    decided += w <= -1 || w >= 0;
    if (expected <= exponent.shell.lower || expected >= escape) continue;
    plunging += v < exponent.knee.at;
    ASSERT_NEAR(read, expected, 1e-5 * (1 + exponent.knee.more)) << w;
  }
  EXPECT_GT(plunging, 100);
  EXPECT_GT(decided, 1000);
}

// From 16.16 to 271.8 was said of a shell whose slope is 16.84 to 282, and of beta one end.
TEST(ExponentGrid, TheRangesOfAShellOfDetailAreThoseOfItsLine) {
  Monitor monitor;
  ExponentGridOptions options{.orbit = {3, 20}};
  const Ramp ramp{.axis = 0, .from = 0.1, .to = 0.4};
  const BBoxd box(Vec3d(-0.5), Vec3d(0.5));
  options.detail =
      DetailOptions{.detail = 0.3, .outward = 0.3, .thickness = Control(ramp, box), .greatestThickness = 0.4};
  const ExponentGrid exponent =
      exponentGrid(makeTarget(test_fields::bandGrid(ball, kTargetVoxel, 0.4, 1e9), {}), {}, options, monitor);
  ASSERT_EQ(exponent.knee.more, 0);
  // Of both ends of the ramp: E's slope in phi, and the phi where E is 0.
  for (const auto& [tau, alpha] :
       {std::pair(0.1, exponent.alphaRange.second), std::pair(0.4, exponent.alphaRange.first)}) {
    const double h = 0.96 * 0.6 * tau, K = *exponent.scale;
    EXPECT_NEAR(alpha, K / h, 1e-6 * K / h);
    const double zero = (0.5 - std::log(20.0) / K) * h;
    const auto [least, most] = exponent.betaRange;
    EXPECT_TRUE(std::abs(zero - least) < 1e-9 || std::abs(zero - most) < 1e-9) << zero << ' ' << least << ' ' << most;
  }
  EXPECT_LT(exponent.betaRange.first, exponent.betaRange.second);
}

TEST(ExponentGrid, RefusesAnAlphaThatIsNotPositive) {
  const Target target = makeTarget(test_fields::bandGrid(ball, kTargetVoxel, 0.4), {});
  Monitor monitor;
  for (const double alpha : {0.0, -3.0})
    EXPECT_THROW(exponentGrid(target, {}, {.alpha = alpha, .beta = 0.0, .orbit = {3, 20}}, monitor),
                 std::invalid_argument)
        << alpha;
  const Ramp ramp{.axis = 0, .from = -1, .to = 10};
  EXPECT_THROW(exponentGrid(target, {}, {.alpha = Control(ramp, target.box), .orbit = {3, 20}}, monitor),
               std::invalid_argument);
}

}  // namespace
