// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/space_options.h"

#include "target/solid_input.h"
#include "vdbtools/target/fit_space.h"

namespace vdbtools {
namespace {

PlacedSpace placed(const FractalSpace& space, const SpaceOptions& options) {
  PlacedSpace result{space, space};
  result.unmoved.centre -= options.origin * space.scale;
  return result;
}

}  // namespace

std::vector<OptionSpec> spaceOptionSpecs() {
  return {
      {.name = "origin",
       .argument = "X,Y,Z",
       .defaultValue = "0,0,0",
       .help = "move the origin of the dynamics, in fractal space, which erodes the set"},
      {.name = "space",
       .argument = "fit|world",
       .defaultValue = "fit",
       .help = "fit: the target is scaled to a longest side of 1 and centred at 0; world: coordinates are used as they "
               "are"},
  };
}

SpaceOptions parseSpaceOptions(const RecipeReader& reader) {
  return {.kind = reader.choice<SpaceKind>("space", {{"fit", SpaceKind::Fit}, {"world", SpaceKind::World}}),
          .origin = reader.vector("origin")};
}

double spaceScale(const SpaceOptions& options, const openvdb::BBoxd& box) {
  return options.kind == SpaceKind::World ? 1 : longestSide(box);
}

bool needsDeepestPoint(const SpaceOptions& options, const Target& target) {
  return options.kind == SpaceKind::Fit && !centreIsInside(*target.phi, target.box);
}

PlacedSpace placeSpace(const SpaceOptions& options, const Target& target) {
  if (options.kind == SpaceKind::World) return placeSpace(options, nullptr);
  return placed(fitFractalSpace(*target.phi, target.box, options.origin), options);
}

PlacedSpace placeSpace(const SpaceOptions& options, const FractalSpace* fitted) {
  FractalSpace space;
  if (fitted && options.kind == SpaceKind::Fit) space = *fitted;
  space.centre += options.origin * space.scale;
  return placed(space, options);
}

}  // namespace vdbtools
