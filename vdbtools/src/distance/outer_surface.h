// SPDX-License-Identifier: Apache-2.0
/// @file outer_surface.h
/// The outer surface of parts that intersect each other (docs/design.md 2.9).
#pragma once

#include "search/triangle_tree.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/distance/mesh_to_sdf.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdbtools {

/// A point of a triangle that has no outside nodes of the lattice next to it: it lies within a part, or in a groove too
/// narrow for the lattice.
struct HiddenPlace {
  std::uint32_t triangle = 0;
  openvdb::Vec3d point;  ///< index space
};

struct OuterSurface {
  std::vector<openvdb::Vec3d> points;
  std::vector<openvdb::Vec3I> triangles;  ///< remaining triangles, and pieces of others, in the mesh's order
  std::vector<std::uint32_t> source;      ///< of each of them, the triangle of the mesh that it is or is a piece of
  PartCounts parts{};
};

/// The parts of a mesh, by the number of surfaces of the solid that enclose them.
struct NestedSurfaces {
  /// The triangles of solids, of the hollows in them, of the solids in these hollows, and so on. The first layer also
  /// has all triangles that bound neither.
  std::vector<std::vector<openvdb::Vec3I>> layers;
  PartCounts parts{};
};

/// Removes everything of a mesh that lies within one of its closed parts; triangles that parts intersect are cut along
/// the intersections. A part is a set of triangles connected across edges. It is closed in two cases: if each of its
/// edges is used equally often in both directions, then points with a non-zero winding number are inside; or if each is
/// used an even number of times, then parity decides. Parts that are not closed hide nothing.
///
/// The result is a set of triangles, not a closed mesh: at a cut, corners may lie on an edge.
/// @param mesh    in index space: points within a few millionths of a voxel of each other count as coincident
/// @param hidden  of all parts. Where no parts' boxes meet, and no closed part uses an edge more than twice, the mesh
/// is examined only if one of these lies within a part
/// @return empty if no triangle lies within a part: the mesh is its own outer surface
/// @throw Interrupted
std::optional<OuterSurface> outerSurface(const TriangleTree& mesh, std::span<const HiddenPlace> hidden,
                                         Monitor& monitor);

/// Finds the hollows of solids. Parts that intersect or touch each other, in more than a point, are one surface. A
/// surface bounds a hollow if the winding number, summed over all parts, is 0 just inside of it and is not 0 just
/// outside of it. Only closed parts whose edges are used equally often in both directions decide: within others there
/// is no hollow.
/// @param mesh  as above
/// @return empty if there is no hollow
/// @throw Interrupted
std::optional<NestedSurfaces> nestedSurfaces(const TriangleTree& mesh, Monitor& monitor);

}  // namespace vdbtools
