// SPDX-License-Identifier: Apache-2.0
/// @file distance_band.h
/// Exact distances to the triangles of a mesh at the nodes of a lattice, in a band of any width about it.
#pragma once

#include "search/triangle_tree.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <string_view>

namespace vdbtools {

/// The distance to the nearest triangle at every node that is less than @a width away, all of them active. Index space,
/// as all here.
/// @return not pruned; the background is @a width
/// @throw Interrupted
openvdb::FloatGrid::Ptr unsignedDistances(const TriangleTree& tree, float width, std::string_view phase,
                                          Monitor& monitor);

/// The same with a sign, in the sense of openvdb::tools::meshToVolume: inside, and negative, is what a flood from far
/// outside does not reach from node to node without coming within half a voxel's diagonal of a triangle; a node that
/// near to one is outside if it lies on the same side as a neighbour that the flood reached.
///
/// Triangles with no outside within three voxels bound nothing: inner walls, and the parts of overlapping solids that
/// lie in each other. Distances are those to the other triangles.
/// @param exterior, interior  widths of the band
/// @param united  if not null, signs and distances are those of the outer surface of parts that run into each other
///                (outer_surface.h), and this becomes the number of those parts
/// @return not pruned, flood filled; the background is @a exterior
/// @throw Interrupted
openvdb::FloatGrid::Ptr signedDistances(const TriangleTree& tree, float exterior, float interior,
                                        std::string_view phase, Monitor& monitor, std::size_t* united = nullptr);

}  // namespace vdbtools
