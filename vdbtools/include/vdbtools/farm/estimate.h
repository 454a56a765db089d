// SPDX-License-Identifier: Apache-2.0
/// @file estimate.h
/// Estimates the cost of a plan from a random sample of its tasks.
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

/// The amount of work of a task as far as it is known before the task is run, in arbitrary units.
struct TaskWork {
  double shell = 0;    ///< number of undecided nodes
  double surface = 0;  ///< area of the surface, as seen on a coarse lattice
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
  Estimated peakBytes;   ///< of one task: the interval contains 95 % of the tasks
};

/// Distinct tasks, each equally likely, in ascending order. The same seed gives the same tasks.
std::vector<std::uint64_t> sampleTasks(std::uint64_t tasks, std::uint64_t count, std::uint64_t seed);

/// Estimates the total of a quantity over all tasks from its values in a random sample without replacement. It uses the
/// regression estimator of survey sampling ([Coc77] chapter 7): a linear function of the work, which is known for all
/// tasks, is fitted to the values, and the residuals give the interval by Student's t. For a sample of fewer than 6
/// tasks, or if all works are equal, the mean is used. Tasks with neither work nor a value count as one task there,
/// because a line through them and a few others fits whatever the others are.
/// @param work    of all tasks
/// @param sample  work and value of each task in the sample, at least two unless there is only one task
/// @throw std::invalid_argument  fewer than two tasks in the sample of a plan that has more than one
Estimated estimateTotal(std::span<const TaskWork> work, std::span<const std::pair<TaskWork, double>> sample);

/// @param work  of all tasks
/// @throw as estimateTotal()
PlanEstimate estimatePlan(std::span<const TaskWork> work, std::span<const SampledTask> sample);

}  // namespace vdbtools::farm
