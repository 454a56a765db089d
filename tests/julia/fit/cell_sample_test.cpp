// SPDX-License-Identifier: Apache-2.0
// Cells that stand for all: their number, what is exact, and how near their sums are.
#include "fit/cell_sample.h"

#include "support/float128.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace {

using julia::CellSample;
using julia::sampleCells;
using law_tests::Random;

/// A few are large, many small, and every fifth is 0.
std::vector<double> unevenValues(Random& random, std::size_t count) {
  std::vector<double> d(count);
  for (double& value : d) value = random.integer(0, 4) == 0 ? 0 : std::exp(random.between(-9, 0));
  return d;
}

TEST(CellSample, allThatCountWhereThereIsRoom) {
  Random random(1);
  const std::vector<double> d = unevenValues(random, 500);
  const auto positive = static_cast<std::size_t>(std::count_if(d.begin(), d.end(), [](double v) { return v > 0; }));
  for (const std::size_t most : {positive, std::size_t{1000}}) {
    const CellSample sample = sampleCells(d, most);
    ASSERT_EQ(sample.cells.size(), positive);
    for (std::size_t k = 0; k < positive; ++k) EXPECT_EQ(sample.weights[k], d[sample.cells[k]]);
  }
  EXPECT_TRUE(sampleCells(std::vector<double>(9, 0.0), 3).cells.empty());
}

TEST(CellSample, isAsLargeAsWantedAndKeepsTheSum) {
  Random random(2);
  for (const std::size_t count : {100, 5000})
    for (const std::size_t most : {1, 7, 50}) {
      const std::vector<double> d = unevenValues(random, count);
      const CellSample sample = sampleCells(d, most);
      EXPECT_LE(sample.cells.size(), most + 1) << count;
      EXPECT_GE(sample.cells.size() + 1, most) << count;
      EXPECT_TRUE(std::is_sorted(sample.cells.begin(), sample.cells.end()));
      EXPECT_EQ(std::adjacent_find(sample.cells.begin(), sample.cells.end()), sample.cells.end());
      const double sum = std::accumulate(d.begin(), d.end(), 0.0);
      const double sampled = std::accumulate(sample.weights.begin(), sample.weights.end(), 0.0);
      // Systematic sampling errs by less than one weight, that of those which share it.
      const double least = *std::min_element(sample.weights.begin(), sample.weights.end());
      EXPECT_NEAR(sampled, sum, 0.51 * least * (1 + 1e-9)) << most << " of " << count;
      for (std::size_t k = 0; k < sample.cells.size(); ++k) {
        EXPECT_GT(d[sample.cells[k]], 0);
        EXPECT_GE(sample.weights[k], d[sample.cells[k]]);
        if (d[sample.cells[k]] > least) {
          EXPECT_EQ(sample.weights[k], d[sample.cells[k]]);
        }
      }
      // Whatever is above the weight they share is there.
      for (std::size_t i = 0; i < count; ++i)
        if (d[i] > least * (1 + 1e-12)) {
          EXPECT_TRUE(std::binary_search(sample.cells.begin(), sample.cells.end(), i)) << i;
        }
    }
}

// Sums of another function than 1: nearer than those of as many cells that are taken at equal distances.
TEST(CellSample, sumsAreNearerThanThoseOfEqualShares) {
  Random random(3);
  double squared = 0, squaredOfEqual = 0;
  for (int round = 0; round < 200; ++round) {
    const std::vector<double> d = unevenValues(random, 4000);
    std::vector<double> f(d.size());
    for (double& value : f) value = random.between(-1, 1);
    double sum = 0, sampled = 0, equal = 0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      sum += f[i] * d[i];
      if (i % 10 == 0) equal += 10 * f[i] * d[i];
    }
    const CellSample sample = sampleCells(d, 400);
    for (std::size_t k = 0; k < sample.cells.size(); ++k) sampled += f[sample.cells[k]] * sample.weights[k];
    squared += (sampled - sum) * (sampled - sum);
    squaredOfEqual += (equal - sum) * (equal - sum);
  }
  EXPECT_LT(squared, 0.25 * squaredOfEqual);
}

}  // namespace
