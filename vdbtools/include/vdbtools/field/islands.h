// SPDX-License-Identifier: Apache-2.0
/// @file islands.h
/// Removes the specks that float around a fractal from its field, before it becomes a mesh or a level set.
///
/// An island is a set of inside nodes (F < 0) that are connected through the 6 neighbours of each node, never across a
/// diagonal; the mesh connects them likewise. Marching cubes cuts off each run of inside corners on a cell's face
/// separately, so a loop in a cell surrounds corners that are connected along the cell's edges and depends on them
/// alone: each such group has its own triangles in the cell. Hence no triangle belongs to two islands, and dropping an
/// island removes its whole surface and leaves every vertex and triangle of the others unchanged.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/field/fractal_field.h"

#include <cstdint>

namespace vdbtools {

struct IslandOptions {
  /// How many of the largest islands to keep, by number of nodes; of equal ones, those whose first node comes first in
  /// the order of (x, y, z). 0: all.
  std::uint64_t largest = 0;
  /// World units. Islands smaller than this are dropped, whatever their rank. The size of an island is the longest side
  /// of the bounding box of its nodes, plus one voxel. 0: no island is too small.
  double minSize = 0;
};

struct IslandReport {
  std::uint64_t islands = 0, keptIslands = 0;
  std::uint64_t droppedNodes = 0;  ///< nodes that were inside and no longer are
};

/// Drops islands. Their nodes, including tiles, get -F: they are outside, and the sign no longer changes around them.
/// Active states and bubbles of the outside within an island stay unchanged. Of an island that the domain's border
/// cuts, only the part within counts. A field without an island is left unchanged.
/// @throw std::invalid_argument  minSize negative or not finite
/// @throw DataError              no island is as large as minSize (Remedy::SmallerIslands); the field is unchanged
/// @throw Interrupted            the field is unchanged
IslandReport dropIslands(FractalField& field, const IslandOptions& options, Monitor& monitor);

}  // namespace vdbtools
