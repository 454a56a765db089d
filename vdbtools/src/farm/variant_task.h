// SPDX-License-Identifier: Apache-2.0
/// @file variant_task.h
/// The tasks of plans of frames and of cells.
#pragma once

#include "vdbtools/farm/task.h"

namespace vdbtools {

/// Makes the files of task @a index, the same bytes as `juliavdb fractal` makes of the task's recipe, and brings all of
/// them to their places together. Counts evaluatedNodes, and of a mesh triangles and points.
/// @throw as makeScene() and writeFractal(); CreateError, IoError
TaskCounts makeVariant(const std::filesystem::path& folder, const Manifest& manifest, std::uint64_t index,
                       Monitor& monitor);

}  // namespace vdbtools
