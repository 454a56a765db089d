// SPDX-License-Identifier: Apache-2.0
/// @file marching_cubes_table.h
/// The triangles of a cell for each of the 256 signs of its corners, derived from three rules:
/// - on every face, a separate segment cuts off each run of inside corners, so that the two cells that share the face
///   agree;
/// - the segments of a cell form closed loops, with one crossing point on each edge;
/// - a loop is split by diagonals between points that share no face, so that no diagonal can coincide with one of a
///   neighbouring cell.
/// The first two rules make the mesh closed, and the third makes it 2-manifold. Such diagonals exist for all 256 cases
/// (a test checks this).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace vdbtools {

/// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2 & 1).
struct CellEdge {
  int corner;  ///< the end with the smaller coordinates
  int axis;    ///< the edge runs from it along this axis
};

/// The 12 edges, in the order in which the triangles refer to them.
const std::array<CellEdge, 12>& cellEdges();

using CellTriangle = std::array<std::uint8_t, 3>;  ///< three edges, counter-clockwise seen from outside

/// @param insideCorners  bit c is set where corner c is inside
const std::vector<CellTriangle>& cellTriangles(unsigned insideCorners);

}  // namespace vdbtools
