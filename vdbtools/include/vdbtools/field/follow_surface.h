// SPDX-License-Identifier: Apache-2.0
/// @file follow_surface.h
/// A field by following its surface, for runs so large or so deeply zoomed that even the shell is too much: from seeds
/// on a coarse lattice, block by block to wherever another sign than a block's own seed comes up to it. What it finds
/// is exact, and its mesh is closed; islands and bubbles that no seed meets are missed. How much that is, a random
/// sample of what was left out tells.
#pragma once

#include "vdbtools/field/fractal_field.h"

#include <cstdint>

namespace vdbtools {

struct FollowOptions {
  int seedStride = 8;           ///< voxels between seeds: a power of 2, at most 64
  std::uint64_t probes = 2000;  ///< blocks that were left out and are looked into to estimate what is missed
};

/// Whether seeds can be so many voxels apart.
bool isSeedStride(int stride);

struct FollowReport {
  std::uint64_t shellBlocks = 0;    ///< of the plan, less those in large cubes whose sign is proved
  std::uint64_t visitedBlocks = 0;  ///< of these
  std::uint64_t probedBlocks = 0;   ///< of those not visited
  /// Vertices: on edges that begin in the visited blocks, and estimated from the probed ones for the rest.
  std::uint64_t foundVertices = 0;
  double missedVertices = 0;

  /// The estimate as a share of all vertices.
  double missedShare() const {
    const double all = static_cast<double>(foundVertices) + missedVertices;
    return all > 0 ? missedVertices / all : 0;
  }
};

/// @return  the field; where it was not evaluated it holds the sign of the nearest seed, and next to that no other
/// @throw std::invalid_argument  a stride out of its domain
FractalField followSurface(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& field,
                           const FollowOptions& options, FollowReport& report, Monitor& monitor);

}  // namespace vdbtools
