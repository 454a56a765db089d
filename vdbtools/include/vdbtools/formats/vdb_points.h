// SPDX-License-Identifier: Apache-2.0
/// @file vdb_points.h
/// Points in VDB files: OpenVDB's point grids, which Houdini reads as packed points.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/mesh/vertex_column.h"

#include <string>
#include <vector>

namespace vdbtools {

/// Returns a grid named "points" of class unknown. Positions are the attribute P, in 32-bit floats relative to the
/// voxels that hold the points; normals, if there are any, are N. Columns keep their names, and texture coordinates get
/// a third component, 0. Points in a voxel keep their order.
/// @param spacing  approximate distance between neighbours, world units, > 0; a voxel is twice as wide
/// @throw std::invalid_argument  no points, or a spacing that is not positive
/// @throw std::logic_error       the number of normals or values does not match the points
openvdb::GridBase::Ptr pointGrid(const PointBatch& points, const std::vector<VertexColumn>& columns, double spacing);

}  // namespace vdbtools
