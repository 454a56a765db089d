// SPDX-License-Identifier: Apache-2.0
/// @file marching_cubes_table.h
/// The triangles of a cell for each of the 256 signs of its corners, derived from three rules:
/// - on every face, each run of inside corners is cut off by a segment of its own, so that the two cells that share the
///   face agree;
/// - the segments of a cell form closed loops, with one crossing point on each edge;
/// - a loop is split by diagonals between points that share no face, so that no diagonal can coincide with one of a
///   neighbour.
/// The first two rules make the mesh closed, the third makes it 2-manifold. Such diagonals exist for all 256 (a test
/// checks this).
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

/// The 12 edges, in the order that the triangles count them.
const std::array<CellEdge, 12>& cellEdges();

using CellTriangle = std::array<std::uint8_t, 3>;  ///< three edges, counter-clockwise seen from outside

/// @param insideCorners  bit c is set where corner c is inside
const std::vector<CellTriangle>& cellTriangles(unsigned insideCorners);

}  // namespace vdbtools
