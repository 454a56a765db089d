// SPDX-License-Identifier: Apache-2.0
/// @file follow_surface.h
/// The field of a fractal by following its surface, for runs so large or so deeply zoomed that even the shell is too
/// much to evaluate: starting from seeds on a coarse lattice, it goes from block to block, to each whose own seed has
/// another sign than the nodes that touch it. What it finds is exact, and its mesh is closed; islands and bubbles that
/// no seed meets are missed. A random sample of the blocks that were left out gives an estimate of how much that is.
#pragma once

#include "vdbtools/field/fractal_field.h"

#include <cstdint>

namespace vdbtools {

struct FollowOptions {
  int seedStride = 8;           ///< voxels between seeds: a power of 2, at most 64
  std::uint64_t probes = 2000;  ///< blocks that are sampled, of those left out, to estimate what is missed
};

/// Whether seeds can be @a stride voxels apart.
bool isSeedStride(int stride);

struct FollowReport {
  std::uint64_t shellBlocks = 0;    ///< of the plan, without those in large cubes whose sign is proved
  std::uint64_t visitedBlocks = 0;  ///< of these
  std::uint64_t probedBlocks = 0;   ///< of those not visited
  /// Vertices of the mesh, closed by caps where the domain cuts the set: those on the edges that begin in visited
  /// blocks, and an estimate of those in the other blocks from the edges that begin in the probed ones.
  std::uint64_t foundVertices = 0;
  double missedVertices = 0;

  /// The estimate as a share of all vertices.
  double missedShare() const {
    const double all = static_cast<double>(foundVertices) + missedVertices;
    return all > 0 ? missedVertices / all : 0;
  }
};

/// @return  the field; in blocks that were not visited it holds the sign of the seed, as do the nodes next to them
/// @throw std::invalid_argument  a stride out of its domain
FractalField followSurface(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& field,
                           const FollowOptions& options, FollowReport& report, Monitor& monitor);

}  // namespace vdbtools
