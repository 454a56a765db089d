// SPDX-License-Identifier: Apache-2.0
/// @file space_options.h
/// The placement of the dynamics in the world, as a recipe specifies it.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <optional>
#include <vector>

namespace vdbtools {

class TargetSurvey;

enum class SpaceKind {
  Fit,    ///< the shape's longest side is 1
  World,  ///< coordinates are unchanged
};

/// Where the origin of the dynamics is placed.
enum class OriginKind {
  Auto,    ///< the centre of the largest inscribed ball for a map with a shell; for others the centre of target.h
  Centre,  ///< the middle of the shape's box
  Given,   ///< a given offset from the middle of the box
};

struct SpaceOptions {
  SpaceKind kind = SpaceKind::Fit;
  OriginKind origin = OriginKind::Auto;
  openvdb::Vec3d at{0, 0, 0};  ///< for a given origin: its offset from the middle of the box, units of fractal space
  std::optional<openvdb::Vec3d>
      near;  ///< decides among nearly equal balls: the nearest to this offset from the middle, or else to the middle
  openvdb::Vec3d shift{0, 0, 0};  ///< moves the dynamics from its origin, units of fractal space

  bool operator==(const SpaceOptions&) const = default;
};

std::vector<OptionSpec> spaceOptionSpecs();
/// @throw std::invalid_argument
SpaceOptions parseSpaceOptions(const RecipeReader& reader);

/// The length of a unit of fractal space for a shape with this box, world units.
double spaceScale(const SpaceOptions& options, const openvdb::BBoxd& box);

struct PlacedSpace {
  FractalSpace space;
  FractalSpace unmoved;  ///< without the shift; random roots are placed in it
};

/// Whether the origin is the centre of the largest inscribed ball.
bool needsInscribedBall(const SpaceOptions& options);
/// Places a map with a shell. @param box  bounds of the shape, world units
/// @param survey  needed where needsInscribedBall(), else nullptr
/// @throw DataError  the shape has no inside
PlacedSpace placeSpace(const SpaceOptions& options, const openvdb::BBoxd& box, const TargetSurvey* survey);

/// Whether placing a map without a shell at this target requires distances deep inside, because the middle of its box
/// lies outside.
bool needsDeepestPoint(const SpaceOptions& options, const Target& target);
/// Places a map without a shell. @throw DataError, std::invalid_argument  as fitFractalSpace()
PlacedSpace placeSpace(const SpaceOptions& options, const Target& target);

/// Places a map without a target. @param fitted  the space in which the map's roots were made, if there is one
PlacedSpace placeSpace(const SpaceOptions& options, const FractalSpace* fitted);

}  // namespace vdbtools
