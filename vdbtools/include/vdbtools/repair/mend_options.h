// SPDX-License-Identifier: Apache-2.0
/// @file mend_options.h
/// How a file that holds no solid becomes a target. Of a mesh that bounds no volume, holes are closed, terrain becomes
/// a block, a sheet a plate, and a point cloud a union of balls; cavities that the result encloses are inside, unless
/// they are to be kept. Of a VDB that holds no signed distance, negative inside, one surface of its values is the
/// target's.
#pragma once

#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// Turns terrain into a block, with walls from its open edges straight down and a flat base.
struct SolidifyOptions {
  double depth = 0;         ///< depth of the base below the lowest point, world units, > 0
  std::optional<int> up{};  ///< 0, 1, 2 for x, y, z; empty: the axis of the largest projected area
  bool operator==(const SolidifyOptions&) const = default;
};

/// Which surface of a VDB is the target's. Without an isovalue it is that of the level set, at 0, or for a fog volume
/// without negative values that at half of its largest one.
struct VolumeOptions {
  /// Where the surface lies. The inside of a level set is below it, in world units, and that of any other grid above
  /// it.
  std::optional<double> isovalue{};
  bool invert = false;  ///< the sign of a level set is turned round first, and the inside of any other grid is below
  bool operator==(const VolumeOptions&) const = default;
};

/// At most one of solidify, thicken and pointsRadius.
struct MendOptions {
  bool repair = false;  ///< closes holes, see repairedMeshToSdf(); with solidify, not the longest loop of a part
  double gap = 0;       ///< as in RepairOptions
  std::optional<SolidifyOptions> solidify{};
  double thicken = 0;       ///< solid of all points within half of this from the mesh, world units; 0: not requested
  double pointsRadius = 0;  ///< solid of all points within this from the mesh's points, world units; 0: not requested
  Hollows hollows = Hollows::Fill;
  VolumeOptions volume{};  ///< of a VDB; the others are of a mesh

  /// Distance of the surface from the mesh, or from its points, world units.
  double offset() const { return pointsRadius > 0 ? pointsRadius : thicken / 2; }
  bool operator==(const MendOptions&) const = default;
};

/// The rule for options that apply to a mesh target but not to a VDB.
std::string idleWithoutMesh(const OptionRun& run);
/// The rule for options that apply to a VDB target but not to a mesh.
std::string idleWithoutVdb(const OptionRun& run);

std::vector<OptionSpec> mendOptionSpecs();
/// @throw std::invalid_argument
MendOptions parseMendOptions(const RecipeReader& reader);

/// All options that differ from their defaults, in a line; different options have different texts.
std::string mendText(const MendOptions& options);

}  // namespace vdbtools
