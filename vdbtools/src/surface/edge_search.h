// SPDX-License-Identifier: Apache-2.0
/// @file edge_search.h
/// Finds where the true F changes sign on lattice edges ([Kim15], [KD20] Fig. 4).
#pragma once

#include "vdbtools/field/fractal_field.h"

#include <optional>
#include <vector>

namespace vdbtools {

struct LatticeEdge {
  openvdb::Coord begin;
  int axis;  ///< the edge runs from begin one voxel along this axis
  float from,
      to;  ///< F at its two ends: one below 0, the other not, or julia::kFieldLimit if no more is known than its sign
  std::optional<double> cut{};  ///< of an edge that leaves the domain, beyond which there is no F: where, from 0 to 1
};

/// @param tolerance  voxels: F changes sign within this of the result
/// @return world positions, one per edge; each depends only on its edge
std::vector<openvdb::Vec3d> searchEdges(const std::vector<LatticeEdge>& edges, double voxelSize,
                                        const FieldSource& source, double tolerance);

}  // namespace vdbtools
