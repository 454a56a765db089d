// SPDX-License-Identifier: Apache-2.0
/// @file lattice_options.h
/// Which nodes of which lattice are evaluated, as a recipe specifies it.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/field/follow_surface.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <optional>
#include <vector>

namespace vdbtools {

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
