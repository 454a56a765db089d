// SPDX-License-Identifier: Apache-2.0
/// @file surface_options.h
/// Which surface is made from a field, as a recipe specifies it.
#pragma once

#include "vdbtools/field/islands.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <vector>

namespace vdbtools {

/// What happens to crumbs (vdbtools/field/crumbs.h). Auto drops crumbs of at most 1/40 of the target's length; sets
/// without a target keep them, because they may consist of nothing else.
enum class Crumbs { Auto, Drop, Keep };

struct SurfaceOptions {
  double tolerance = 1e-3;  ///< distance of a vertex to the true surface, voxels
  Crumbs crumbs = Crumbs::Auto;
  IslandOptions islands;
  /// Voxels. Triangles become as large as this distance from the full mesh allows (adaptive_mesh.h). 0: all are kept.
  double adaptivity = 0;
  bool cap = false;  ///< closes the mesh where the box cuts the set
};

std::vector<OptionSpec> surfaceOptionSpecs();
/// @throw std::invalid_argument
SurfaceOptions parseSurfaceOptions(const RecipeReader& reader);

}  // namespace vdbtools
