// SPDX-License-Identifier: Apache-2.0
// The measure of a fit against maps whose fit is known.
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/fit/fit_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <sstream>

namespace {

using namespace vdbtools;
using namespace vdbtools::fit;

constexpr double kSharpness = 100;

/// A sphere of diameter 1 in fractal space.
const FitTarget& measuredSphere() {
  static const FitTarget target = [] {
    const TemporaryFolder folder;
    std::ostringstream obj;
    writeMesh(obj, test_meshes::makeSphere(2.0, 5, {1, -2, 3}), {.format = &meshFormat(".obj")});
    Monitor monitor;
    return makeFitTarget({.input = folder.write("sphere.obj", obj.str()), .resolution = 48}, monitor);
  }();
  return target;
}

FitMeasure measure(const julia::Rational& rational) {
  Monitor monitor;
  return measureFit(measuredSphere(), rational, kSharpness, monitor);
}

/// |q| / r to the power: inside of a sphere for 1, outside of it for -1.
julia::Rational ball(double radius, double power = 1) {
  julia::Rational rational;
  rational.logScale = -power * std::log(radius);
  (power > 0 ? rational.top : rational.bottom).roots = {{{0, 0, 0, 0}, std::abs(power)}};
  return rational;
}

TEST(FitMeasure, SphereFitsItself) {
  const FitMeasure fit = measure(ball(0.5));
  EXPECT_GT(fit.iou, 0.99);
  EXPECT_LT(fit.meanDistance, 0.2 * measuredSphere().cell);
  EXPECT_LT(fit.hausdorff, measuredSphere().cell);
  EXPECT_LT(fit.psi, -0.9);
  EXPECT_GE(fit.psi, -1);
}

TEST(FitMeasure, OppositeIsWorst) {
  const FitMeasure fit = measure(ball(0.5, -1));
  EXPECT_LT(fit.iou, 0.01);
  EXPECT_GT(fit.psi, 0.9);
  EXPECT_LE(fit.psi, 1);
  EXPECT_EQ(fit.wrongCells + measure(ball(0.5)).wrongCells, 48u * 48u * 48u);
}

TEST(FitMeasure, SmallerSphereByItsVolumeAndDistance) {
  const FitMeasure fit = measure(ball(0.4));
  EXPECT_NEAR(fit.iou, 0.512, 0.01);
  EXPECT_NEAR(fit.meanDistance, 0.1, 0.2 * measuredSphere().cell);
  EXPECT_NEAR(fit.hausdorff, 0.1, measuredSphere().cell);
}

TEST(FitMeasure, MoreIterationsAreMeasuredToo) {
  // (|q| / r)^2 again and again: after n steps the surface is at r^(2 - 2^(1 - n)).
  const double radius = 0.5;
  EXPECT_GT(measure(ball(radius, 2)).iou, 0.99);
  Monitor monitor;
  for (const int n : {1, 2, 4}) {
    const double expected = std::pow(std::pow(radius, 1 - std::pow(2, 1 - n)), 3);
    EXPECT_NEAR(iteratedIou(measuredSphere(), ball(radius, 2), {.iterations = n}, monitor), expected, 0.01) << n;
    EXPECT_NEAR(iteratedIou(measuredSphere(), ball(radius, 2), {.iterations = n, .every = 3}, monitor), expected, 0.04)
        << n;
  }
}

// Promise: "`fit` chooses C anew at the end, for the iterations ..."
TEST(FitMeasure, TheShiftOfCMakesUpForTheIterations) {
  // Where |R| = 1 is the sphere of the target, the sets of more iterations are larger, until C is smaller.
  const double radius = 0.5;
  Monitor monitor;
  EXPECT_EQ(scaleShift(measuredSphere(), ball(radius, 2), 1, monitor), 0);
  for (const int n : {2, 3, 4}) {
    julia::Rational map = ball(radius, 2);
    map.logScale += scaleShift(measuredSphere(), map, n, monitor);
    EXPECT_GT(iteratedIou(measuredSphere(), map, {.iterations = n}, monitor), 0.98) << n;
  }
}

TEST(FitMeasure, NoSurfaceIsInfinitelyFar) {
  julia::Rational everywhereOutside = ball(0.5);
  everywhereOutside.logScale = 1000;
  const FitMeasure fit = measure(everywhereOutside);
  EXPECT_EQ(fit.iou, 0);
  EXPECT_TRUE(std::isinf(fit.meanDistance));
  EXPECT_TRUE(std::isinf(fit.hausdorff));
  EXPECT_GT(fit.psi, -1);
  EXPECT_LT(fit.psi, 1);
}

TEST(FitMeasure, SameForAnyThreads) {
  FitMeasure fits[2];
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    fits[threads - 1] = measure(ball(0.45, 2));
  }
  EXPECT_EQ(fits[0].psi, fits[1].psi);
  EXPECT_EQ(fits[0].meanDistance, fits[1].meanDistance);
  EXPECT_EQ(fits[0].hausdorff, fits[1].hausdorff);
}

TEST(FitMeasure, RefusesABadSharpness) {
  Monitor monitor;
  EXPECT_THROW(measureFit(measuredSphere(), ball(0.5), 0, monitor), std::invalid_argument);
}

}  // namespace
