// SPDX-License-Identifier: Apache-2.0
/// @file mend_options.h
/// How a mesh that bounds no volume becomes a target: holes are closed, terrain becomes a block, a sheet a plate, and a
/// cloud of points a union of balls. What these make is a solid like any other; hollows that it encloses are inside.
#pragma once

#include "vdbtools/recipe/recipe_reader.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// Terrain as a block: walls from its open edges straight down, and a flat base.
struct SolidifyOptions {
  double depth = 0;         ///< of the base below the lowest point, world units, > 0
  std::optional<int> up{};  ///< 0, 1, 2 for x, y, z; none: the axis along which the mesh shows the largest area
  bool operator==(const SolidifyOptions&) const = default;
};

/// At most one of solidify, thicken and pointsRadius.
struct MendOptions {
  bool repair = false;  ///< closes holes, see repairedMeshToSdf(); with solidify, all but the longest loop of each part
  double gap = 0;       ///< as RepairOptions
  std::optional<SolidifyOptions> solidify{};
  double thicken = 0;       ///< the points within half of this from the mesh, world units; 0: not asked for
  double pointsRadius = 0;  ///< the points within this from the mesh's points, world units; 0: not asked for

  /// How far from the mesh, or from its points, the surface lies, world units.
  double offset() const { return pointsRadius > 0 ? pointsRadius : thicken / 2; }
  bool operator==(const MendOptions&) const = default;
};

/// The rule of options that a mesh as the target has and a VDB has not.
std::string idleWithoutMesh(const OptionRun& run);

std::vector<OptionSpec> mendOptionSpecs();
/// @throw std::invalid_argument
MendOptions parseMendOptions(const RecipeReader& reader);

/// All that is not at its default, in a line; different for different options.
std::string mendText(const MendOptions& options);

}  // namespace vdbtools
