// SPDX-License-Identifier: Apache-2.0
/// @file hole_caps.h
/// The loops of open edges of a mesh, and surfaces that span them.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vdbtools {

/// The points of a closed path along open edges, without repetition, in the direction in which most of the adjacent
/// triangles have these edges.
using BoundaryLoop = std::vector<std::uint32_t>;

/// An edge of only one triangle, from a to b in that triangle's direction.
struct OpenEdge {
  std::uint32_t a = 0, b = 0;
  std::uint32_t triangle = 0;
};

/// Edges are ordered by their smaller and then their larger ends.
std::vector<OpenEdge> openEdges(const Mesh& welded);

/// Loops that touch in a point are separated there. Open edges that are on no loop, such as those next to an edge of
/// three triangles, are left out.
std::vector<BoundaryLoop> boundaryLoops(const Mesh& welded);

/// Appends the triangulation of a loop that has the smallest area ([BS95]), oriented like the mesh that the loop
/// bounds. A loop of more than a few hundred points is first split into paths of that length.
void spanLoop(std::span<const std::uint32_t> loop, const std::vector<openvdb::Vec3d>& points,
              std::vector<openvdb::Vec3I>& triangles);

double areaOf(std::span<const openvdb::Vec3I> triangles, const std::vector<openvdb::Vec3d>& points);

struct HoleCappedMesh {
  Mesh mesh{};
  std::size_t caps = 0;
  double widest = 0;     ///< the longest side of the largest bounding box of a capped loop, world units
  std::size_t gaps = 0;  ///< number of loops that were left open as sides of gaps
  /// Whether all parts with open edges are sheets: the surface bounded by a loop is hardly larger than the cap that
  /// spans it, as in terrain, so there is no solid of which the loop could be a hole.
  bool sheetsOnly = false;
};

/// Caps the holes of solids. Sheets are left open, and, unless @a gapsToo, loops that mostly run close to others,
/// because these are the two sides of a gap.
/// @param welded  the result of weldMesh()
HoleCappedMesh capHoles(Mesh welded, bool gapsToo = false);

/// Caps all loops but the longest of each part.
Mesh capInnerLoops(Mesh welded);

/// Whether a mesh is one part, open, and a sheet in the sense of HoleCappedMesh.
bool isOneSheet(const Mesh& welded);

}  // namespace vdbtools
