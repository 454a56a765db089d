// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/grid_plan.h"

#include <algorithm>

namespace vdbtools {

bool GridPlan::has(OutputGrid grid) const { return std::find(grids.begin(), grids.end(), grid) != grids.end(); }

bool GridPlan::needsLevelSet() const {
  return has(OutputGrid::Surface) || has(OutputGrid::Density) || has(OutputGrid::Versor) || attributes;
}

EvaluateFieldOptions GridPlan::evaluation() const {
  const bool iterations = has(OutputGrid::Iterations);
  return {.keepIterations = iterations, .everyNode = iterations || has(OutputGrid::LogModulus)};
}

GridPlan planGrids(const OutputOptions& output) { return {output.grids, !output.attributes.empty()}; }

}  // namespace vdbtools
