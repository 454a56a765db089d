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

/// A grid named "points" of class unknown. Positions are the attribute P, in 32-bit floats relative to the voxels that
/// hold the points; normals, if there are any, are N; columns keep their names, and texture coordinates get a third
/// component, 0. In a voxel, points keep the order that they came in.
/// @param spacing  about the distance between neighbours, world units, > 0: a voxel is twice as wide
/// @throw std::invalid_argument  no points, or a spacing that is not positive
/// @throw std::logic_error       another number of normals or values than the points need
openvdb::GridBase::Ptr pointGrid(const PointBatch& points, const std::vector<VertexColumn>& columns, double spacing);

}  // namespace vdbtools
