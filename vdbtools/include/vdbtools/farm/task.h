// SPDX-License-Identifier: Apache-2.0
/// @file task.h
/// One task of a plan: made, recorded by a side-car, and judged by it later.
///
/// A side-car is DIR/tasks/0007.json, written after the task's files are in their places. It has the task's hash and,
/// for each file, its size and SHA-256. A task whose side-car does not fit its files or its plan is not done.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/manifest.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace vdbtools {

/// What the maker of a task gives back, its files being in their places.
struct TaskCounts {
  std::map<std::string, double> counts;  ///< "triangles", "points", "evaluatedNodes" and the like
};

/// Makes the files of task @a index, each whole or not at all.
/// @throw what the job of its kind throws
TaskCounts makeTask(const std::filesystem::path& folder, const Manifest& manifest, std::uint64_t index,
                    Monitor& monitor);

}  // namespace vdbtools
