// SPDX-License-Identifier: Apache-2.0
/// @file lattice_options.h
/// Which nodes of which lattice are evaluated, as a recipe specifies it.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

// Evaluates the field of a fractal by following its surface, for runs so large or so deeply zoomed that even
// evaluating the shell is too expensive. Starting from seeds on a coarse lattice, it moves from block to block, to
// each block whose seed differs in sign from the adjacent nodes. What it finds is exact, and its mesh is closed, but
// it misses islands and bubbles that no seed meets. A random sample of the blocks that were left out estimates how
// much is missed.

struct FollowOptions {
  int seedStride = 8;           ///< voxels between seeds: a power of 2, at most 64
  std::uint64_t probes = 2000;  ///< number of blocks sampled, among those left out, to estimate what is missed
};

/// Whether seeds can be @a stride voxels apart.
bool isSeedStride(int stride);

struct FollowReport {
  std::uint64_t shellBlocks = 0;    ///< blocks of the plan, without those in large cubes whose sign is proved
  std::uint64_t visitedBlocks = 0;  ///< shell blocks that were visited
  std::uint64_t probedBlocks = 0;   ///< shell blocks that were not visited but sampled
  /// Vertices of the mesh, closed by caps where the domain cuts the set: the number on edges that begin in visited
  /// blocks, and an estimate of the number in the other blocks, from the edges that begin in probed blocks.
  std::uint64_t foundVertices = 0;
  double missedVertices = 0;

  /// The estimated share of all vertices that is missed.
  double missedShare() const {
    const double all = static_cast<double>(foundVertices) + missedVertices;
    return all > 0 ? missedVertices / all : 0;
  }
};

/// @return the field; in blocks that were not visited, and at the nodes next to them, it holds the sign of the seed
/// @throw std::invalid_argument  a stride out of its domain
FractalField followSurface(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& field,
                           const FollowOptions& options, FollowReport& report, Monitor& monitor);

struct LatticeOptions {
  VoxelChoice voxels;                   ///< the voxels of the result
  bool automatic = false;               ///< chooses voxels that resolve the texture instead (scene/voxel_advice.h)
  bool withinMemory = true;             ///< with automatic: limits the voxels to what fits into this process' memory
  std::optional<openvdb::BBoxd> box;    ///< only this region, world units
  bool exhaustive = false;              ///< evaluates every node, even where the result is known
  std::optional<FollowOptions> follow;  ///< set if the surface is to be followed
};

/// Whether a recipe leaves the number of voxels to the program.
bool hasAutomaticResolution(const Recipe& recipe);

std::vector<OptionSpec> latticeOptionSpecs();
/// @throw std::invalid_argument
LatticeOptions parseLatticeOptions(const RecipeReader& reader);

}  // namespace vdbtools
