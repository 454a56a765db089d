// SPDX-License-Identifier: Apache-2.0
/// @file edge_search.h
/// Where the true F changes sign on lattice edges ([Kim15], [KD20] Fig. 4).
#pragma once

#include "vdbtools/field/fractal_field.h"

#include <vector>

namespace vdbtools {

struct LatticeEdge {
  openvdb::Coord begin;
  int axis;        ///< the edge runs from begin one voxel along this axis
  float from, to;  ///< F at its two ends: one below 0, the other not, or julia::kFieldLimit where only that is known
  bool cut;        ///< it leaves the domain: there is no F to search, and the middle is taken
};

/// @param tolerance  voxels: F changes sign within this of the result
/// @return world positions, one an edge; each depends on its edge alone
std::vector<openvdb::Vec3d> searchEdges(const std::vector<LatticeEdge>& edges, double voxelSize,
                                        const FieldSource& source, double tolerance);

}  // namespace vdbtools
