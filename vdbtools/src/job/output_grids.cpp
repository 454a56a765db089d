// SPDX-License-Identifier: Apache-2.0
#include "job/output_grids.h"

#include "vdbtools/surface/level_set.h"

namespace vdbtools {

std::vector<openvdb::GridBase::Ptr> outputGrids(const GridPlan& plan, const GridSources& sources, Monitor& monitor) {
  std::vector<openvdb::GridBase::Ptr> grids;
  for (const OutputGrid grid : plan.grids) switch (grid) {
      case OutputGrid::Surface: grids.push_back(sources.surface); break;
      case OutputGrid::Density: grids.push_back(densityGrid(*sources.surface)); break;
      case OutputGrid::LogModulus: grids.push_back(logModulusGrid(*sources.field)); break;
      case OutputGrid::Iterations: grids.push_back(sources.field->iterations); break;
      case OutputGrid::Versor: grids.push_back(versorGrid(*sources.surface, *sources.source, monitor)); break;
    }
  if (plan.attributes)
    for (const openvdb::GridBase::Ptr& grid : attributeGrids(*sources.attributes, *sources.surface, monitor))
      grids.push_back(grid);
  return grids;
}

void moveGrids(const std::vector<openvdb::GridBase::Ptr>& grids, const openvdb::Vec3d& offset) {
  if (offset == openvdb::Vec3d(0)) return;
  for (const openvdb::GridBase::Ptr& grid : grids) {
    const openvdb::math::Transform::Ptr moved = grid->transform().copy();
    moved->postTranslate(offset);
    grid->setTransform(moved);
  }
}

}  // namespace vdbtools
