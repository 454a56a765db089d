// SPDX-License-Identifier: Apache-2.0
/// @file surface_options.h
/// Which surface is made of a field, as a recipe says it.
#pragma once

#include "vdbtools/field/islands.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <vector>

namespace vdbtools {

/// What happens to crumbs (vdbtools/field/crumbs.h). Auto: around a target those are dropped that are no longer than
/// 1/40 of it; sets without one keep them, as they may consist of nothing else.
enum class Crumbs { Auto, Drop, Keep };

struct SurfaceOptions {
  double tolerance = 1e-3;  ///< how near a vertex lies to the true surface, voxels
  Crumbs crumbs = Crumbs::Auto;
  IslandOptions islands;
  /// Voxels: triangles of the mesh are as large as this distance from the whole mesh allows (adaptive_mesh.h). 0: they
  /// all stay.
  double adaptivity = 0;
  bool cap = false;  ///< closes the mesh where the box cuts the set
};

std::vector<OptionSpec> surfaceOptionSpecs();
/// @throw std::invalid_argument
SurfaceOptions parseSurfaceOptions(const RecipeReader& reader);

}  // namespace vdbtools
