// SPDX-License-Identifier: Apache-2.0
/// @file simplify.h
/// Levels of detail: fewer triangles over the same points, by collapsing edges in the order of their quadric error
/// (Garland and Heckbert, "Surface simplification using quadric error metrics", 1997), with meshoptimizer.
#pragma once

#include <openvdb/Types.h>

#include <span>
#include <vector>

namespace vdbtools {

struct SimplifiedTriangles {
  std::vector<openvdb::Vec3I> triangles;
  double error = 0;  ///< an estimate of how far the surface has moved, in the units of the positions
};

/// @param positions  three floats for each point
/// @param share      the requested fraction of the triangles, 0 to 1. More remain if the topology does not allow fewer;
///                   all remain if a closed surface, such as a tetrahedron, would become flat or vanish
SimplifiedTriangles simplified(std::span<const float> positions, std::span<const openvdb::Vec3I> triangles,
                               double share);

}  // namespace vdbtools
