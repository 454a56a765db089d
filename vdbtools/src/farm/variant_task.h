// SPDX-License-Identifier: Apache-2.0
/// @file variant_task.h
/// The tasks of plans of frames and of cells.
#pragma once

#include "vdbtools/farm/task.h"

#include "vdbtools/scene/scene.h"

#include <string>

namespace vdbtools::farm {

/// Makes the tasks of one plan, one after another; what they share of a target is made once.
class VariantMaker {
 public:
  /// @param folder, manifest  of the plan
  VariantMaker(std::filesystem::path folder, const Manifest& manifest);
  VariantMaker(const VariantMaker&) = delete;
  VariantMaker& operator=(const VariantMaker&) = delete;

  /// Makes the files of task @a index, the same bytes as `juliavdb fractal` makes of the task's recipe, and brings all
  /// of them to their places together. Counts evaluatedNodes, and of a mesh triangles and points.
  /// @throw DataError  the plan has a recipe that is none
  /// @throw as makeScene() and writeFractal(); CreateError, IoError
  TaskCounts make(std::uint64_t index, Monitor& monitor);

 private:
  std::filesystem::path mFolder;
  Manifest mManifest;
  std::uint64_t mIndex = 0;  ///< of the present task
  SceneMaker mScenes;
};

/// One task.
TaskCounts makeVariant(const std::filesystem::path& folder, const Manifest& manifest, std::uint64_t index,
                       Monitor& monitor);

/// Removes the distances (target_store.h) that no task needs any more: those of targets whose tasks are all done. A
/// task that is made again makes them again.
void removeUnneededTargets(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace vdbtools::farm
