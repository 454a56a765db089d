// SPDX-License-Identifier: Apache-2.0
/// @file outer_surface.h
/// The outer surface of parts that run into each other (docs/design.md 2.9).
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace vdbtools {

struct OuterSurface {
  std::vector<openvdb::Vec3d> points;
  std::vector<openvdb::Vec3I> triangles;  ///< those that are left, and what is left of others, in the mesh's order
  std::size_t parts = 0;                  ///< that lie in each other somewhere; one that crosses itself counts, too
};

/// What remains of a mesh without all that lies within one of its closed parts: triangles that parts cross are cut
/// along the crossings. A part is a set of triangles that are connected across edges. It is closed if each of its edges
/// is used as often in one direction as in the other, and what it winds around is inside; or if each is used an even
/// number of times, and parity decides. Parts that are not closed bury nothing.
///
/// The result is a set of triangles, not a closed mesh: at a cut, corners may lie on an edge.
/// @param points  index space: what is nearer together than some millionths of a voxel counts as coincident
/// @param within  also where no closed part's box meets another part's: a part may cross itself
/// @return nothing if no triangle lies within a part: the mesh is its own outer surface
/// @throw Interrupted
std::optional<OuterSurface> outerSurface(const std::vector<openvdb::Vec3d>& points,
                                         const std::vector<openvdb::Vec3I>& triangles, bool within, Monitor& monitor);

}  // namespace vdbtools
