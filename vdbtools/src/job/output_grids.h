// SPDX-License-Identifier: Apache-2.0
/// @file output_grids.h
/// The grids of a fractal, made from its field and its level set.
#pragma once

#include "job/point_attributes.h"

#include "vdbtools/field/fractal_field.h"
#include "vdbtools/scene/grid_plan.h"

#include <vector>

namespace vdbtools {

struct GridSources {
  openvdb::FloatGrid::Ptr surface;              ///< the level set, if the plan needs it
  const FractalField* field = nullptr;          ///< with all nodes and iterations, if the plan has grids of it
  const FieldSource* source = nullptr;          ///< if the plan has the grid "versor"
  const PointAttributes* attributes = nullptr;  ///< if the plan has attributes
};

/// @throw Interrupted
std::vector<openvdb::GridBase::Ptr> outputGrids(const GridPlan& plan, const GridSources& sources, Monitor& monitor);

/// Moves grids that leave the program. @param offset  as latticeOffset() has it, world units
void moveGrids(const std::vector<openvdb::GridBase::Ptr>& grids, const openvdb::Vec3d& offset);

}  // namespace vdbtools
