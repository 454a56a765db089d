// SPDX-License-Identifier: Apache-2.0
/// @file space_options.h
/// Where the dynamics lies in the world, as a recipe says it.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <optional>
#include <vector>

namespace vdbtools {

enum class SpaceKind {
  Fit,    ///< the shape's longest side is 1
  World,  ///< coordinates as they are
};

/// Where the origin of the dynamics is placed.
enum class OriginKind {
  Auto,    ///< for a map with a shell the centre of the largest inscribed ball; for others that of fit_space.h
  Centre,  ///< the middle of the shape's box
  Given,   ///< a given offset from there
};

struct SpaceOptions {
  SpaceKind kind = SpaceKind::Fit;
  OriginKind origin = OriginKind::Auto;
  openvdb::Vec3d at{0, 0, 0};  ///< of a given origin, units of fractal space from the middle of the box
  std::optional<openvdb::Vec3d>
      near;                       ///< among nearly equal balls the nearest to this, given likewise; else the middle
  openvdb::Vec3d shift{0, 0, 0};  ///< moves the dynamics from there, units of fractal space

  bool operator==(const SpaceOptions&) const = default;
};

std::vector<OptionSpec> spaceOptionSpecs();
/// @throw std::invalid_argument
SpaceOptions parseSpaceOptions(const RecipeReader& reader);

/// A unit of fractal space for a shape of this box, world units.
double spaceScale(const SpaceOptions& options, const openvdb::BBoxd& box);

struct PlacedSpace {
  FractalSpace space;
  FractalSpace unmoved;  ///< without the shift: where random roots are strewn
};

/// Whether the origin is the centre of the largest inscribed ball.
bool needsInscribedBall(const SpaceOptions& options);
/// For a map with a shell. @param box  of the shape, world units
/// @param phi  the distances over its whole inside (world units); needed where needsInscribedBall(), else nullptr
/// @throw DataError  phi is nowhere negative
PlacedSpace placeSpace(const SpaceOptions& options, const openvdb::BBoxd& box, const openvdb::FloatGrid* phi);

/// Whether finding the space of this target for a map without a shell takes distances deep inside, because the middle
/// of its box lies outside.
bool needsDeepestPoint(const SpaceOptions& options, const Target& target);
/// For a map without a shell. @throw DataError, std::invalid_argument  as fitFractalSpace()
PlacedSpace placeSpace(const SpaceOptions& options, const Target& target);

/// Without a target. @param fitted  the space that the map's roots were made in, if there is one
PlacedSpace placeSpace(const SpaceOptions& options, const FractalSpace* fitted);

}  // namespace vdbtools
