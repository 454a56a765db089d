// SPDX-License-Identifier: Apache-2.0
/// @file point_cloud.h
/// Points without a surface, as a scanner gives them.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <vector>

namespace vdbtools {

/// As readMesh(), of the points of a file that may have no triangles: those that it has are left out, and their texture
/// coordinates with them. See asPoints().
/// @throw as readMesh()
/// @throw DataError  there is no point
Mesh readPoints(const std::filesystem::path& path);

/// The points of a mesh. Each has a triangle without area, with all three corners there, so that whatever reads the
/// surface nearest to a place reads the nearest point.
Mesh asPoints(Mesh mesh);

/// The median distance of a point from the nearest other one, of some of the points spread over the list, world units;
/// 0 for fewer than two points. It is to the radius of points what the length of edges is to a surface.
double pointSpacing(const std::vector<openvdb::Vec3d>& points);

}  // namespace vdbtools
