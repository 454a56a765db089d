// SPDX-License-Identifier: Apache-2.0
/// @file edge_search.h
/// Edges of a lattice on which F changes its sign, and how near to the change a search ends ([Kim15], [KD20] Fig. 4).
#pragma once

#include "julia/embedding.h"

#include <array>
#include <cstdint>

namespace julia {

/// An edge from one node of a lattice to the next, one voxel along an axis.
struct CrossedEdge {
  Point begin;       ///< its beginning, as F is evaluated there
  int axis = 0;      ///< the coordinate along which it runs
  double index = 0;  ///< of its beginning along that axis, in index space
  float from = 0;    ///< F at its beginning; kFieldLimit with the sign of F if no more is known
  float to = 0;      ///< the same at its end; one of the two is below 0, and the other is not
};

/// Such an edge between two nodes of a lattice, by its numbers.
struct NodeEdge {
  std::array<std::int32_t, 3> node{};  ///< its beginning
  int axis = 0;                        ///< as in CrossedEdge
  float from = 0, to = 0;              ///< as in CrossedEdge
};

/// A lattice of nodes, and how precisely its edges are searched.
struct SearchLattice {
  double voxelSize = 1;  ///< node n has the coordinate (n voxelSize - centre) / scale along an axis
  std::array<double, 3> centre{};
  double scale = 1;
  double tolerance = 1e-3;  ///< voxels: F changes its sign within this of what is found

  /// The coordinate of a place in index space.
  double at(double index, int axis) const {
    return (index * voxelSize - centre[static_cast<std::size_t>(axis)]) / scale;
  }
};

/// The width of a bracket that is narrow enough, in voxels: the middle of the last bracket is within half of it.
inline double narrowBracket(const SearchLattice& lattice) { return 2 * lattice.tolerance; }

/// The largest number of evaluations of an edge: as many as bisection needs, and one more for interpolation. Rounding
/// may cost another one.
int mostEvaluations(const SearchLattice& lattice);

}  // namespace julia
