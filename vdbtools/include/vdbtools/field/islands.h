// SPDX-License-Identifier: Apache-2.0
/// @file islands.h
/// Drops the specks that float about a fractal from its field, before that becomes a mesh or a level set.
///
/// An island is a set of inside nodes (F < 0) joined through the 6 neighbours of a node, never across a diagonal: that
/// is how the mesh sees them. Marching cubes cuts off each run of inside corners on a cell's face by itself, so a loop
/// in a cell runs around corners that are joined along the cell's edges, and depends on them alone: the triangles of a
/// cell are those of each such group without the others. Hence no triangle belongs to two islands; to drop one takes
/// its surface away whole, and leaves every vertex and triangle of the others as it was.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/field/fractal_field.h"

#include <cstdint>

namespace vdbtools {

struct IslandOptions {
  /// Keep that many of the largest islands, by number of nodes; of equal ones, the one whose first node comes first in
  /// the order of (x, y, z). 0: all.
  std::uint64_t largest = 0;
  /// World units: drop islands that are smaller than this, whatever their rank. The size of an island is the longest
  /// side of the box around its nodes, plus one voxel. 0: none.
  double minSize = 0;
};

struct IslandReport {
  std::uint64_t islands = 0, kept = 0;
  std::uint64_t droppedNodes = 0;  ///< that were inside, and are not any more
};

/// The nodes of dropped islands get -F, tiles included: outside, with no change of sign around them. Active states
/// stay, and so do bubbles of the outside within an island. An island that the domain's border cuts counts by what is
/// within. A field without any island is left as it is.
/// @throw std::invalid_argument  minSize negative or not finite
/// @throw DataError              no island is as large as minSize; the field is unchanged
/// @throw Interrupted            likewise
IslandReport dropIslands(FractalField& field, const IslandOptions& options, Monitor& monitor);

}  // namespace vdbtools
