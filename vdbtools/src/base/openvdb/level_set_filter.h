// SPDX-License-Identifier: Apache-2.0
/// @file level_set_filter.h
/// openvdb::tools::LevelSetFilter, instantiated once.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

namespace vdbtools {

/// Moves a level set by mean curvature flow. Each step corresponds to heat diffusion over a third of a voxel squared.
/// @throw Interrupted
void meanCurvatureFlow(openvdb::FloatGrid& levelSet, int steps, const Monitor& monitor);

}  // namespace vdbtools
