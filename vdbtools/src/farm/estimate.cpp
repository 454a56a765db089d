// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/estimate.h"

#include "base/students_t.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>

namespace vdbtools::farm {
namespace {

double countOf(const TaskRecord& record, const char* name) {
  const auto found = record.counts.find(name);
  return found == record.counts.end() ? 0 : static_cast<double>(found->second);
}

using Vector = std::array<double, 2>;

Vector vectorOf(const TaskWork& work) { return {work.shell, work.surface}; }

/// The number of tasks in the sample that help to determine a line through it. Tasks without work and without a value
/// all lie on the same point, so they count as one.
std::size_t tellingTasks(std::span<const std::pair<TaskWork, double>> sample) {
  const auto empty = static_cast<std::size_t>(std::ranges::count_if(
      sample, [](const auto& one) { return one.first.shell == 0 && one.first.surface == 0 && one.second == 0; }));
  return sample.size() - empty + std::min<std::size_t>(empty, 1);
}

/// A linear function of the work fitted to a sample, or its mean.
class Fit {
 public:
  explicit Fit(std::span<const std::pair<TaskWork, double>> sample) {
    const auto count = static_cast<double>(sample.size());
    for (const auto& [work, value] : sample) {
      for (std::size_t k = 0; k < 2; ++k) mMeanWork[k] += vectorOf(work)[k] / count;
      mMeanValue += value / count;
    }
    double xx = 0, xy = 0, yy = 0;  // centred moments of the work
    Vector both{};
    for (const auto& [work, value] : sample) {
      const Vector d = about(work);
      xx += d[0] * d[0];
      xy += d[0] * d[1];
      yy += d[1] * d[1];
      for (std::size_t k = 0; k < 2; ++k) both[k] += d[k] * (value - mMeanValue);
    }
    constexpr std::size_t kLeastForSlopes = 6;
    constexpr double kNone = 1e-9;
    const std::size_t telling = tellingTasks(sample);
    const auto spreads = [&](double squares, std::size_t k) {
      return telling >= kLeastForSlopes && squares > kNone * count * mMeanWork[k] * mMeanWork[k];
    };
    const bool first = spreads(xx, 0), second = spreads(yy, 1);
    const double determinant = xx * yy - xy * xy;
    int slopes = 1;
    if (first && second && determinant > kNone * xx * yy) {
      mInverse = {{{yy / determinant, -xy / determinant}, {-xy / determinant, xx / determinant}}};
      slopes = 2;
    } else if (second) {
      mInverse[1][1] = 1 / yy;
    } else if (first) {
      mInverse[0][0] = 1 / xx;
    } else {
      slopes = 0;
    }
    for (std::size_t k = 0; k < 2; ++k) mSlope[k] = mInverse[k][0] * both[0] + mInverse[k][1] * both[1];
    mDegrees = static_cast<int>(slopes > 0 ? telling : sample.size()) - 1 - slopes;
    if (mDegrees < 1) return;
    for (const auto& [work, value] : sample) {
      const double residual = value - at(about(work));
      mVariance += residual * residual / mDegrees;
    }
  }

  Vector about(const TaskWork& work) const {
    return {vectorOf(work)[0] - mMeanWork[0], vectorOf(work)[1] - mMeanWork[1]};
  }
  /// The value for work with this deviation from the sample's mean.
  double at(const Vector& d) const { return mMeanValue + mSlope[0] * d[0] + mSlope[1] * d[1]; }
  /// The variance of the estimated mean over @a tasks, from the sample's own mean and its slopes at @a d.
  double varianceOfMean(const Vector& d, double tasks, double sampled) const {
    const double lever =
        d[0] * (mInverse[0][0] * d[0] + mInverse[0][1] * d[1]) + d[1] * (mInverse[1][0] * d[0] + mInverse[1][1] * d[1]);
    return mVariance * ((1 - sampled / tasks) / sampled + lever);
  }
  /// The half width of the interval in standard errors; infinite if the sample is too small.
  double reach() const { return mDegrees >= 1 ? studentsT95(mDegrees) : std::numeric_limits<double>::infinity(); }

 private:
  Vector mMeanWork{}, mSlope{};
  std::array<Vector, 2> mInverse{};
  double mMeanValue = 0, mVariance = 0;
  int mDegrees = 0;
};

}  // namespace

std::vector<std::uint64_t> sampleTasks(std::uint64_t tasks, std::uint64_t count, std::uint64_t seed) {
  std::vector<std::uint64_t> all(tasks);
  std::iota(all.begin(), all.end(), std::uint64_t{1});
  // The distributions of the standard library differ between implementations.
  std::mt19937_64 random(seed);
  count = std::min(count, tasks);
  for (std::uint64_t i = 0; i < count; ++i) std::swap(all[i], all[i + random() % (tasks - i)]);
  all.resize(count);
  std::sort(all.begin(), all.end());
  return all;
}

Estimated estimateTotal(std::span<const TaskWork> work, std::span<const std::pair<TaskWork, double>> sample) {
  if (sample.empty() || (sample.size() < 2 && work.size() > 1))
    throw std::invalid_argument("a sample of " + std::to_string(sample.size()) + " of " + std::to_string(work.size()) +
                                " tasks tells no interval; take two or more");
  const auto tasks = static_cast<double>(work.size());
  TaskWork mean;
  for (const TaskWork& one : work) {
    mean.shell += one.shell / tasks;
    mean.surface += one.surface / tasks;
  }
  const Fit fit(sample);
  const Vector away = fit.about(mean);
  const double value = tasks * fit.at(away);
  // Nothing is uncertain if all tasks are in the sample.
  const double error =
      sample.size() < work.size()
          ? tasks * fit.reach() * std::sqrt(fit.varianceOfMean(away, tasks, static_cast<double>(sample.size())))
          : 0;
  // The total is at least the sum of the sample.
  double least = 0;
  for (const auto& [unused, one] : sample) least += one;
  return {std::max(value, least), std::max(value - error, least), std::max(value + error, least)};
}

PlanEstimate estimatePlan(std::span<const TaskWork> work, std::span<const SampledTask> sample) {
  PlanEstimate estimate{.sampled = sample.size(), .tasks = work.size()};
  const auto values = [&](const auto& valueOf) {
    std::vector<std::pair<TaskWork, double>> pairs;
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
  const int degrees = static_cast<int>(peaks.size()) - 1;
  for (const auto& [unused, peak] : peaks) variance += degrees > 0 ? (peak - mean) * (peak - mean) / degrees : 0;
  const double reach =
      degrees > 0 ? studentsT95(degrees) * std::sqrt(variance * (1 + 1 / static_cast<double>(peaks.size()))) : 0;
  estimate.peakBytes = {mean, std::max(0.0, mean - reach), mean + reach};
  return estimate;
}

}  // namespace vdbtools::farm
