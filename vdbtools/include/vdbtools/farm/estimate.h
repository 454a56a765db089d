// SPDX-License-Identifier: Apache-2.0
/// @file estimate.h
/// What a plan will take, from a random sample of its tasks.
#pragma once

#include "vdbtools/farm/task.h"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace vdbtools::farm {

struct Estimated {
  double value = 0;
  double low = 0, high = 0;  ///< the 95 % interval
};

/// What is known of a task before it is made: how much there is to do, in units that do not matter.
struct TaskWork {
  double shell = 0;    ///< undecided nodes
  double surface = 0;  ///< surface, as a coarse lattice shows it
};

/// A task of the sample.
struct SampledTask {
  TaskWork work;
  TaskRecord record;
};

struct PlanEstimate {
  std::uint64_t sampled = 0, tasks = 0;
  Estimated triangles;   ///< of all tasks
  Estimated cpuSeconds;  ///< of all tasks
  Estimated diskBytes;   ///< of all tasks' files
  Estimated peakBytes;   ///< of one task: 95 % of the tasks lie in the interval
};

/// Different tasks, each equally likely; ascending. The same for the same seed.
std::vector<std::uint64_t> sampleTasks(std::uint64_t tasks, std::uint64_t count, std::uint64_t seed);

/// The total of a quantity over all tasks, from its values in a random sample without replacement. The regression
/// estimator of survey sampling is used ([Coc77] chapter 7): the values are fitted by a linear function of the work,
/// which is known for all tasks, and what scatters about it gives the interval by Student's t. In a sample of fewer
/// than 6 tasks, or where the works are all equal, this is the mean.
/// @param work    of all tasks
/// @param sample  work and value of each task in the sample, two at least unless there is only one task
/// @throw std::invalid_argument  fewer than two tasks in the sample of a plan that has more than one
Estimated estimateTotal(std::span<const TaskWork> work, std::span<const std::pair<TaskWork, double>> sample);

/// @param work  of all tasks
/// @throw as estimateTotal()
PlanEstimate estimatePlan(std::span<const TaskWork> work, std::span<const SampledTask> sample);

}  // namespace vdbtools::farm
