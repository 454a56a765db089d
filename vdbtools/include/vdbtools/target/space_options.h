// SPDX-License-Identifier: Apache-2.0
/// @file space_options.h
/// Where the dynamics lies in the world, as a recipe says it.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/target/exponent_grid.h"

#include <vector>

namespace vdbtools {

enum class SpaceKind {
  Fit,    ///< the shape's longest side is 1 and its centre 0
  World,  ///< coordinates as they are
};

struct SpaceOptions {
  SpaceKind kind = SpaceKind::Fit;
  openvdb::Vec3d origin{0, 0, 0};  ///< moves the dynamics' origin, units of fractal space
};

std::vector<OptionSpec> spaceOptionSpecs();
/// @throw std::invalid_argument
SpaceOptions parseSpaceOptions(const RecipeReader& reader);

/// A unit of fractal space for a shape of this box, world units.
double spaceScale(const SpaceOptions& options, const openvdb::BBoxd& box);

/// Whether finding the space of this target takes distances deep inside, because the middle of its box lies outside.
bool needsDeepestPoint(const SpaceOptions& options, const Target& target);

struct PlacedSpace {
  FractalSpace space;
  FractalSpace unmoved;  ///< with the origin where it was before it was moved: where random roots are strewn
};

/// @throw DataError, std::invalid_argument  as fitFractalSpace()
PlacedSpace placeSpace(const SpaceOptions& options, const Target& target);
/// Without a target. @param fitted  the space that the map's roots were made in, if there is one
PlacedSpace placeSpace(const SpaceOptions& options, const FractalSpace* fitted);

}  // namespace vdbtools
