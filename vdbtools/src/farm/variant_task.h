// SPDX-License-Identifier: Apache-2.0
/// @file variant_task.h
/// The tasks of plans of frames and of cells.
#pragma once

#include "vdbtools/farm/task.h"

#include "vdbtools/scene/scene.h"

#include <string>

namespace vdbtools::farm {

/// Runs the tasks of one plan one after another; what they share of a target is computed once.
class VariantMaker {
 public:
  /// @param folder, manifest  of the plan
  VariantMaker(std::filesystem::path folder, const Manifest& manifest);
  VariantMaker(const VariantMaker&) = delete;
  VariantMaker& operator=(const VariantMaker&) = delete;

  /// Makes the files of task @a index, with the same bytes as `juliavdb fractal` makes from the task's recipe, and
  /// commits all of them together. Counts evaluatedNodes and, for a mesh, triangles and points.
  /// @throw DataError  the plan has an invalid recipe
  /// @throw as makeScene() and writeFractal(); CreateError, IoError
  TaskCounts make(std::uint64_t index, Monitor& monitor);

 private:
  std::filesystem::path mFolder;
  Manifest mManifest;
  std::uint64_t mIndex = 0;  ///< index of the current task
  SceneMaker mScenes;
};

/// Removes the stored distances (target_store.h) of targets whose tasks are all done. A task that is run again computes
/// them again.
void removeUnneededTargets(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace vdbtools::farm
