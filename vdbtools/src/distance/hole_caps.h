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

/// The points of a closed way along open edges, none of them twice, in the direction in which most of the triangles
/// there have these edges.
using BoundaryLoop = std::vector<std::uint32_t>;

/// An edge of one triangle only, from a to b as that triangle has it.
struct OpenEdge {
  std::uint32_t a = 0, b = 0;
  std::uint32_t triangle = 0;
};

/// In the order of their smaller and larger ends.
std::vector<OpenEdge> openEdges(const Mesh& welded);

/// Where loops touch in a point they are parted there. Open edges that are on no loop, as beside an edge of three
/// triangles, are left out.
std::vector<BoundaryLoop> boundaryLoops(const Mesh& welded);

/// Appends the triangulation of a loop that has the smallest area ([BS95]), oriented as the mesh
/// that the loop bounds. A loop of more than some hundred points is cut into ways of that many first.
void spanLoop(std::span<const std::uint32_t> loop, const std::vector<openvdb::Vec3d>& points,
              std::vector<openvdb::Vec3I>& triangles);

double areaOf(std::span<const openvdb::Vec3I> triangles, const std::vector<openvdb::Vec3d>& points);

struct CappedMesh {
  Mesh mesh{};
  std::size_t caps = 0;
  double widest = 0;     ///< the longest side of the largest box about a capped loop, world units
  std::size_t gaps = 0;  ///< loops that were left open as sides of gaps
  /// All parts with open edges are sheets: the surface over a loop is hardly larger than the surface that spans it, as
  /// in terrain, and there is no solid of which the loop could be a hole.
  bool sheetsOnly = false;
};

/// Caps the holes of solids. Left open are sheets, and unless @a gapsToo loops of which the greater part runs near to
/// others: these are the two sides of a gap.
/// @param welded  as weldMesh() gives it
CappedMesh capHoles(Mesh welded, bool gapsToo = false);

/// Caps all loops but the longest of each part.
Mesh capInnerLoops(Mesh welded);

/// Whether a mesh is one part, open, and a sheet in the sense of CappedMesh.
bool isOneSheet(const Mesh& welded);

}  // namespace vdbtools
