// SPDX-License-Identifier: Apache-2.0
/// @file grid_plan.h
/// Which grids are made of a fractal, and what they need. A single run, the tasks of a farm and their merging use the
/// same plan.
#pragma once

#include "vdbtools/field/fractal_field.h"
#include "vdbtools/scene/fractal_options.h"

#include <vector>

namespace vdbtools {

struct GridPlan {
  std::vector<OutputGrid> grids{};  ///< in the order of the file
  bool attributes = false;          ///< a grid of each attribute, over the band of the level set

  bool has(OutputGrid grid) const;
  bool empty() const { return grids.empty() && !attributes; }
  /// Whether distances to the mesh are needed: a level set in a narrow band.
  bool needsLevelSet() const;
  /// How the field is evaluated for the grids.
  EvaluateFieldOptions evaluation() const;
};

/// All grids that the options name.
GridPlan planGrids(const OutputOptions& output);

}  // namespace vdbtools
