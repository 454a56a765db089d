// SPDX-License-Identifier: Apache-2.0
/// @file point_cloud.h
/// Points without a surface, such as those of a scanner.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <vector>

namespace vdbtools {

/// Reads the points of a file as readMesh() does. The file may have no triangles; those that it has are left out, and
/// so are their texture coordinates. See asPoints().
/// @throw as readMesh()
/// @throw DataError  there is no point
Mesh readPoints(const std::filesystem::path& path);

/// The points of a mesh. Each becomes a triangle without area, with all three corners at the point, so that a search
/// for the nearest surface finds the nearest point.
Mesh asPoints(Mesh mesh);

/// The median distance of a point from its nearest neighbour, for a sample of points spread over the list, world units;
/// 0 for fewer than two points. It relates to the radius of points as the length of edges does to a surface.
double pointSpacing(const std::vector<openvdb::Vec3d>& points);

}  // namespace vdbtools
