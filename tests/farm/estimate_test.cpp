// SPDX-License-Identifier: Apache-2.0
// What a sample of tasks says of all of them.
#include "vdbtools/farm/estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <stdexcept>

namespace {

using namespace vdbtools;
using namespace vdbtools::farm;

using Pairs = std::vector<std::pair<TaskWork, double>>;

struct Population {
  std::vector<TaskWork> work;
  std::vector<double> value;
  double total = 0;

  Population(std::mt19937& random, std::size_t tasks, double scatter) {
    for (std::size_t i = 0; i < tasks; ++i) {
      const auto unit = [&] { return static_cast<double>(random()) / 0x1p32; };
      work.push_back({50 + 100 * unit(), 7 * unit()});
      value.push_back(30 + 2 * work.back().shell + 40 * work.back().surface +
                      scatter * (unit() + unit() + unit() - 1.5));
      total += value.back();
    }
  }
  Pairs sample(std::uint64_t count, std::uint64_t seed) const {
    Pairs pairs;
    for (const std::uint64_t index : sampleTasks(work.size(), count, seed))
      pairs.emplace_back(work[index - 1], value[index - 1]);
    return pairs;
  }
};

TEST(Estimate, SamplesAreDifferentTasksAndEachIsAsLikely) {
  std::vector<int> hits(20, 0);
  constexpr int kRounds = 4000, kCount = 5;
  for (int seed = 0; seed < kRounds; ++seed) {
    const auto sample = sampleTasks(hits.size(), kCount, static_cast<std::uint64_t>(seed));
    EXPECT_EQ(std::set<std::uint64_t>(sample.begin(), sample.end()).size(), std::size_t{kCount});
    EXPECT_TRUE(std::is_sorted(sample.begin(), sample.end()));
    for (const std::uint64_t index : sample) ++hits.at(index - 1);
  }
  // Five standard deviations of a binomial distribution.
  const double mean = kRounds * kCount / 20.0, deviation = std::sqrt(mean * 0.75);
  for (const int count : hits) EXPECT_NEAR(count, mean, 5 * deviation);
  EXPECT_EQ(sampleTasks(3, 10, 1).size(), 3U);
}

TEST(Estimate, AllTasksTellTheTotalAndALineIsFollowedExactly) {
  std::mt19937 random(1);
  const Population scattered(random, 40, 100);
  const Estimated all = estimateTotal(scattered.work, scattered.sample(40, 1));
  EXPECT_NEAR(all.value, scattered.total, 1e-9 * scattered.total);
  EXPECT_NEAR(all.low, all.high, 1e-9 * scattered.total);
  const Population line(random, 40, 0);
  const Estimated few = estimateTotal(line.work, line.sample(7, 3));
  EXPECT_NEAR(few.value, line.total, 1e-9 * line.total);
  EXPECT_NEAR(few.high - few.low, 0, 1e-6 * line.total);
}

// Promise: `--estimate`: the truth lies ...
TEST(Estimate, TheIntervalHoldsTheTotalNineteenTimesInTwenty) {
  std::mt19937 random(2);
  int held = 0;
  constexpr int kRounds = 1000;
  for (int round = 0; round < kRounds; ++round) {
    const Population population(random, 60, 150);
    const Estimated estimated =
        estimateTotal(population.work, population.sample(10, static_cast<std::uint64_t>(round)));
    held += estimated.low <= population.total && population.total <= estimated.high;
  }
  // 950 are expected, with a standard deviation of 7; the scatter is not quite normal.
  EXPECT_GT(held, 910);
  EXPECT_LT(held, 990);
}

/// A plan most of whose tasks have neither work nor a value, as far from the surface.
Population mostlyEmpty(std::mt19937& random) {
  Population population(random, 100, 150);
  for (std::size_t i = 0; i < population.work.size(); ++i) {
    if (random() % 4 == 0) continue;
    population.total -= population.value[i];
    population.work[i] = {0, 0};
    population.value[i] = 0;
  }
  return population;
}

TEST(Estimate, EmptyTasksGiveNoCertainty) {
  std::mt19937 random(3);
  int held = 0;
  constexpr int kRounds = 1000;
  for (int round = 0; round < kRounds; ++round) {
    const Population population = mostlyEmpty(random);
    const Pairs sample = population.sample(12, static_cast<std::uint64_t>(round));
    const auto full = std::count_if(sample.begin(), sample.end(), [](const auto& one) { return one.second > 0; });
    const Estimated estimated = estimateTotal(population.work, sample);
    if (full > 0) {
      EXPECT_GT(estimated.high - estimated.low, 1e-6 * estimated.value) << full << " tasks with a value";
    }
    held += estimated.low <= population.total && population.total <= estimated.high;
  }
  // The number of tasks with a value, three of twelve or so, is far from normal, so the interval holds the total in 90
  // rounds of 100 and not in 95; of 1000 rounds with a standard deviation of 10.
  EXPECT_GT(held, 860);
}

TEST(Estimate, EqualWorksGiveTheMean) {
  const std::vector<TaskWork> work(10, {5, 1});
  const Estimated estimated =
      estimateTotal(work, Pairs{{{5, 1}, 1}, {{5, 1}, 3}, {{5, 1}, 2}, {{5, 1}, 4}, {{5, 1}, 5}, {{5, 1}, 3}});
  EXPECT_DOUBLE_EQ(estimated.value, 30);
  EXPECT_LT(estimated.low, 30);
  EXPECT_GE(estimated.low, 18) << "less than the sample itself";
}

// Promise: "Counts have 64 bits everywhere: in the records ..."
TEST(Estimate, AllTasksTellCountsThat32BitsDoNotHold) {
  std::vector<TaskWork> work;
  std::vector<SampledTask> sample;
  std::uint64_t triangles = 0, bytes = 0;
  for (std::uint64_t i = 1; i <= 9; ++i) {
    TaskRecord record;
    record.counts["triangles"] = (std::uint64_t{1} << 32) + i;
    record.files = {{.name = "tile", .bytes = (std::uint64_t{1} << 35) + i}};
    triangles += record.counts["triangles"];
    bytes += record.files[0].bytes;
    work.push_back({static_cast<double>(i), 1});
    sample.push_back({work.back(), record});
  }
  const PlanEstimate estimate = estimatePlan(work, sample);
  EXPECT_NEAR(estimate.triangles.value, static_cast<double>(triangles), 1);
  EXPECT_NEAR(estimate.diskBytes.value, static_cast<double>(bytes), 1);
}

TEST(Estimate, OneTaskTellsNothingOfOthers) {
  const std::vector<TaskWork> work(10, {5, 1});
  EXPECT_THROW(estimateTotal(work, Pairs{{{5, 1}, 1}}), std::invalid_argument);
  EXPECT_DOUBLE_EQ(estimateTotal(std::vector<TaskWork>{{5, 1}}, Pairs{{{5, 1}, 7}}).value, 7);
}

}  // namespace
