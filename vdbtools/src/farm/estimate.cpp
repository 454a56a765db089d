// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/estimate.h"

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

/// By how many standard errors the 95 % interval reaches to either side.
double studentsT(double degrees) { return boost::math::quantile(boost::math::students_t(degrees), 0.975); }

double countOf(const TaskRecord& record, const char* name) {
  const auto found = record.counts.find(name);
  return found == record.counts.end() ? 0 : found->second;
}

/// A line through a sample, or its mean.
struct Fit {
  double meanWork = 0, meanValue = 0, slope = 0;
  double spread = 0;    ///< of the work: the sum of squares about the mean
  double variance = 0;  ///< of what the line leaves
  double degrees = 0;   ///< of freedom; 0: no variance can be told

  explicit Fit(std::span<const std::pair<double, double>> sample) {
    const auto count = static_cast<double>(sample.size());
    for (const auto& [work, value] : sample) {
      meanWork += work / count;
      meanValue += value / count;
    }
    double both = 0;
    for (const auto& [work, value] : sample) {
      spread += (work - meanWork) * (work - meanWork);
      both += (work - meanWork) * (value - meanValue);
    }
    constexpr std::size_t kLeastForLine = 4;
    constexpr double kNoSpread = 1e-12;
    const bool line = sample.size() >= kLeastForLine && spread > kNoSpread * meanWork * meanWork;
    if (line) slope = both / spread;
    degrees = count - (line ? 2 : 1);
    if (degrees < 1) return;
    for (const auto& [work, value] : sample) {
      const double rest = value - meanValue - slope * (work - meanWork);
      variance += rest * rest / degrees;
    }
  }
};

}  // namespace

std::vector<std::uint64_t> sampleTasks(std::uint64_t tasks, std::uint64_t count, std::uint64_t seed) {
  std::vector<std::uint64_t> all(tasks);
  std::iota(all.begin(), all.end(), std::uint64_t{1});
  // No distribution of the standard library, which are not the same everywhere.
  std::mt19937_64 random(seed);
  count = std::min(count, tasks);
  for (std::uint64_t i = 0; i < count; ++i) std::swap(all[i], all[i + random() % (tasks - i)]);
  all.resize(count);
  std::sort(all.begin(), all.end());
  return all;
}

Estimated estimateTotal(std::span<const double> work, std::span<const std::pair<double, double>> sample) {
  if (sample.empty() || (sample.size() < 2 && work.size() > 1))
    throw std::invalid_argument("a sample of " + std::to_string(sample.size()) + " of " + std::to_string(work.size()) +
                                " tasks tells no interval; take two or more");
  const auto tasks = static_cast<double>(work.size()), count = static_cast<double>(sample.size());
  const double meanWork = std::accumulate(work.begin(), work.end(), 0.0) / tasks;
  const Fit fit(sample);
  const double value = tasks * (fit.meanValue + fit.slope * (meanWork - fit.meanWork));
  const double rest = 1 - count / tasks;  // nothing is uncertain once all tasks are in the sample
  double error = 0;
  if (rest > 0) {
    const double away = meanWork - fit.meanWork;
    error = tasks * std::sqrt(fit.variance * (rest / count + (fit.slope != 0 ? away * away / fit.spread : 0)));
    error *= fit.degrees >= 1 ? studentsT(fit.degrees) : std::numeric_limits<double>::infinity();
  }
  // What the sample has is there.
  double least = 0;
  for (const auto& [unused, one] : sample) least += one;
  return {std::max(value, least), std::max(value - error, least), std::max(value + error, least)};
}

PlanEstimate estimatePlan(std::span<const double> work, std::span<const SampledTask> sample) {
  PlanEstimate estimate{.sampled = sample.size(), .tasks = work.size()};
  const auto values = [&](const auto& valueOf) {
    std::vector<std::pair<double, double>> pairs;
    for (const SampledTask& task : sample) pairs.emplace_back(task.work, valueOf(task.record));
    return pairs;
  };
  estimate.triangles =
      estimateTotal(work, values([](const TaskRecord& record) { return countOf(record, "triangles"); }));
  estimate.cpuSeconds = estimateTotal(work, values([](const TaskRecord& record) { return record.cpuSeconds; }));
  estimate.diskBytes = estimateTotal(work, values([](const TaskRecord& record) {
                                       double bytes = 0;
                                       for (const TaskFile& file : record.files)
                                         bytes += static_cast<double>(file.bytes);
                                       return bytes;
                                     }));
  const auto peaks = values([](const TaskRecord& record) { return static_cast<double>(record.peakBytes); });
  double mean = 0, variance = 0;
  for (const auto& [unused, peak] : peaks) mean += peak / static_cast<double>(peaks.size());
  const double degrees = static_cast<double>(peaks.size()) - 1;
  for (const auto& [unused, peak] : peaks) variance += degrees > 0 ? (peak - mean) * (peak - mean) / degrees : 0;
  const double reach =
      degrees > 0 ? studentsT(degrees) * std::sqrt(variance * (1 + 1 / static_cast<double>(peaks.size()))) : 0;
  estimate.peakBytes = {mean, std::max(0.0, mean - reach), mean + reach};
  return estimate;
}

}  // namespace vdbtools
