// SPDX-License-Identifier: Apache-2.0
/// @file distance_band.h
/// Exact distances to the triangles of a mesh at the nodes of a lattice, in a band of any width around it.
#pragma once

#include "search/triangle_tree.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/distance/mesh_to_sdf.h"

#include <string_view>

namespace vdbtools {

/// Computes the distance to the nearest triangle at every node that is less than @a width away; these nodes are active.
/// Like everything here, it works in index space.
/// @return the grid, not pruned; the background is @a width
/// @throw Interrupted
openvdb::FloatGrid::Ptr unsignedDistances(const TriangleTree& tree, float width, const Phase& phase, Monitor& monitor);

/// Computes signed distances, with the sign of openvdb::tools::meshToVolume. A node is inside, and negative, if a flood
/// from far outside does not reach it from node to node without coming within half a voxel's diagonal of a triangle. A
/// node that close to a triangle is outside if it lies on the same side as a neighbour that the flood reached.
///
/// Triangles with no outside within three voxels bound nothing: inner walls, and the parts of overlapping solids that
/// lie inside each other. Distances are those to the other triangles.
/// @param exterior, interior  widths of the band
/// @param counts  if not null, signs and distances are those of the outer surface of parts that intersect each other
///                (outer_surface.h), and this receives what was found of the parts
/// @param hollows  Hollows::Keep needs counts
/// @return the grid, not pruned, flood filled; the background is @a exterior
/// @throw Interrupted
openvdb::FloatGrid::Ptr signedDistances(const TriangleTree& tree, float exterior, float interior, const Phase& phase,
                                        Monitor& monitor, PartCounts* counts = nullptr,
                                        Hollows hollows = Hollows::Fill);

}  // namespace vdbtools
