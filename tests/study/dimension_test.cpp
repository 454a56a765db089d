// SPDX-License-Identifier: Apache-2.0
// The growth of meshes with their resolution, and the fit of a power law to it.
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/study/study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>
#include <stdexcept>

namespace {

using namespace vdbtools;
using Points = std::vector<std::pair<double, double>>;

TEST(PowerLaw, OfAnExactLawIsThatLaw) {
  for (const double exponent : {2.0, 2.1868, -1.5, 0.0}) {
    Points points;
    for (const double x : {40.0, 80.0, 100.0, 1000.0}) points.emplace_back(x, 7.5 * std::pow(x, exponent));
    const PowerLaw law = fitPowerLaw(points);
    EXPECT_NEAR(law.exponent, exponent, 1e-12);
    EXPECT_NEAR(law.factor, 7.5, 1e-10);
    EXPECT_NEAR(law.standardError, 0, 1e-12);
  }
}

// Of a law with noise of a normal distribution, the true exponent lies in 95 of 100 intervals.
// Promise: "`juliavdb study --dimension N,N,...` ..."
TEST(PowerLaw, IntervalsHoldTheTrueExponentAsOftenAsTheySay) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.03);
  for (const int count : {3, 5, 12}) {
    constexpr int kTrials = 4000;
    int held = 0;
    double errors = 0, squares = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      Points points;
      for (int i = 0; i < count; ++i) {
        const double x = 50 * std::pow(1.5, i);
        points.emplace_back(x, 3 * std::pow(x, 2.2) * std::exp(noise(random)));
      }
      const PowerLaw law = fitPowerLaw(points);
      held += law.interval.first <= 2.2 && 2.2 <= law.interval.second;
      errors += law.standardError * law.standardError;
      squares += (law.exponent - 2.2) * (law.exponent - 2.2);
    }
    // The share varies by 0.0034, one standard deviation.
    EXPECT_NEAR(held / static_cast<double>(kTrials), 0.95, 0.015) << count << " points";
    EXPECT_NEAR(std::sqrt(errors / squares), 1, 0.05) << "the standard error is the spread of the exponent";
  }
}

TEST(PowerLaw, RefusesWhatHasNone) {
  EXPECT_THROW(fitPowerLaw(Points{{1, 1}, {2, 4}}), std::invalid_argument);
  EXPECT_THROW(fitPowerLaw(Points{{1, 1}, {2, 4}, {3, 0}}), std::invalid_argument);
  EXPECT_THROW(fitPowerLaw(Points{{0, 1}, {2, 4}, {3, 9}}), std::invalid_argument);
  EXPECT_THROW(fitPowerLaw(Points{{2, 1}, {2, 4}, {2, 9}}), std::invalid_argument);
}

class Dimension : public testing::Test {
 protected:
  Dimension() {
    std::ostringstream stream;
    writeMesh(stream, test_meshes::makeSphere(1, 3), {.format = &meshFormat(".obj")});
    mBall = mFolder.write("ball.obj", stream.str()).string();
  }

  std::vector<GrowthRow> rows(Recipe recipe) {
    recipe["input"] = mBall;
    recipe["sdf-resolution"] = "40";
    const std::vector<int> resolutions{24, 36, 54, 81};
    return measureGrowth(parseFractalOptions(recipe), resolutions, mMonitor);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
  std::string mBall;
};

// Promise: "`juliavdb study --dimension N,N,...` ..."
TEST_F(Dimension, OfAPlainSphereIsTwo) {
  const PowerLaw law = growthLaw(rows({{"mask", "0"}}));
  EXPECT_NEAR(law.exponent, 2, 0.02);
  EXPECT_LT(law.standardError, 0.01);
}

TEST_F(Dimension, OfAFractalIsBetweenTwoAndThree) {
  const std::vector<GrowthRow> rough = rows({{"alpha", "10"}, {"iterations", "6"}});
  const PowerLaw law = growthLaw(rough);
  EXPECT_GT(law.interval.first, 2.05);
  EXPECT_LT(law.exponent, 3);
  // Each island is closed: V = F / 2 + 2 - 2 genus.
  for (const GrowthRow& row : rough)
    EXPECT_NEAR(static_cast<double>(row.points) / static_cast<double>(row.triangles), 0.5, 0.05);
}

}  // namespace
