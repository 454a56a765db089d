// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/space_options.h"

#include "recipe/option_rows.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/target/target_survey.h"

#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Vec3d;

constexpr const char* kAutoOrigin = "auto";
constexpr const char* kCentre = "centre";

PlacedSpace shifted(const FractalSpace& unmoved, const SpaceOptions& options) {
  PlacedSpace placed{unmoved, unmoved};
  placed.space.centre += options.shift * unmoved.scale;
  return placed;
}

/// Fractal space centred on the middle of a shape's box, before an origin is chosen.
FractalSpace aboutTheMiddle(const SpaceOptions& options, const BBoxd& box) {
  FractalSpace space;
  if (options.kind == SpaceKind::World) return space;
  space.scale = longestSide(box);
  space.centre = box.getCenter();
  return space;
}

/// World coordinates have their own origin.
std::string idleOrigin(const OptionRun& run) {
  const std::string origin = run.text("origin");
  if (run.text("space") != "world" || (origin != "auto" && origin != "centre")) return {};
  return "--space world takes coordinates as they are, and '" + origin +
         "' is a place in the target; give X,Y,Z, or leave it out";
}

std::string idleOriginNear(const OptionRun& run) {
  if (!run.recipe.contains("input")) return "it chooses a place in the target, and there is no target; leave it out";
  if (run.text("space") == "world")
    return "it is for --origin auto, and --space world takes coordinates as they are; leave it out";
  if (run.text("map") != "shape-modulus")
    return "it is for --origin auto of --map shape-modulus, and --map is " + run.text("map") +
           "; leave it out, or give --origin X,Y,Z";
  return {};
}

/// A rational map may have been fitted to a shape, which is scaled like a target.
std::string idleSpace(const OptionRun& run) {
  return run.recipe.contains("input") || run.text("map") == "rational"
             ? ""
             : "it says how a target is scaled, and there is no target; leave it out";
}

void parseOrigin(const RecipeReader& reader, const std::string& name, SpaceOptions& options) {
  const std::string origin = reader.text(name);
  if (origin == kAutoOrigin) return;
  if (origin == kCentre) {
    options.origin = OriginKind::Centre;
    return;
  }
  options.origin = OriginKind::Given;
  try {
    options.at = reader.vector(name);
  } catch (const std::invalid_argument&) {
    reader.refuse(name, "auto, centre, or three finite numbers with commas between them");
  }
}

const OptionRows<SpaceOptions>& spaceRows() {
  static const OptionRows<SpaceOptions> rows{
      {{.name = "origin",
        .argument = "auto|centre|X,Y,Z",
        .defaultValue = kAutoOrigin,
        .help =
            "where in the target the origin of the dynamics lies. auto: at the centre of the largest ball inside it "
            "(other maps than shape-modulus: as centre); centre: in the middle of its box; or an offset from there "
            "in fractal space",
        .idle = idleOrigin},
       parsedBy(parseOrigin, {.kind = OptionType::Kind::Vector, .words = {kAutoOrigin, kCentre}})},
      {{.name = "origin-near",
        .argument = "X,Y,Z",
        .help =
            "for --origin auto: among balls of nearly the same size choose the nearest to this point, given like an "
            "origin (default: the middle of the box)",
        .idle = idleOriginNear},
       vector(&SpaceOptions::near)},
      {{.name = "origin-shift",
        .argument = "X,Y,Z",
        .help = "move the dynamics from its origin, in fractal space, which erodes the set"},
       vector(&SpaceOptions::shift)},
      {{.name = "space",
        .help =
            "fit: the target is scaled to a longest side of 1 about the origin; world: coordinates are used as they "
            "are",
        .idle = idleSpace},
       choice<SpaceKind>(&SpaceOptions::kind, {{"fit", SpaceKind::Fit}, {"world", SpaceKind::World}})},
  };
  return rows;
}

}  // namespace

std::vector<OptionSpec> spaceOptionSpecs() { return spaceRows().specs(); }

SpaceOptions parseSpaceOptions(const RecipeReader& reader) {
  const SpaceOptions options = spaceRows().read(reader);
  if (options.near && options.origin != OriginKind::Auto)
    throw std::invalid_argument("--origin-near is for --origin auto, but --origin is '" + reader.text("origin") +
                                "'; give only one of them");
  return options;
}

double spaceScale(const SpaceOptions& options, const BBoxd& box) {
  return options.kind == SpaceKind::World ? 1 : longestSide(box);
}

bool needsInscribedBall(const SpaceOptions& options) {
  return options.kind == SpaceKind::Fit && options.origin == OriginKind::Auto;
}

PlacedSpace placeSpace(const SpaceOptions& options, const BBoxd& box, const TargetSurvey* survey) {
  FractalSpace space = aboutTheMiddle(options, box);
  if (needsInscribedBall(options)) {
    const Vec3d preferred = space.centre + options.near.value_or(Vec3d(0)) * space.scale;
    space.centre = survey->largestBall(preferred).centre;
  } else {
    space.centre += options.at * space.scale;
  }
  return shifted(space, options);
}

bool needsDeepestPoint(const SpaceOptions& options, const Target& target) {
  return options.kind == SpaceKind::Fit && options.origin == OriginKind::Auto &&
         !centreIsInside(*target.phi, target.box);
}

PlacedSpace placeSpace(const SpaceOptions& options, const Target& target) {
  if (options.kind == SpaceKind::Fit && options.origin == OriginKind::Auto)
    return shifted(fitFractalSpace(*target.phi, target.box), options);
  FractalSpace space = aboutTheMiddle(options, target.box);
  space.centre += options.at * space.scale;
  return shifted(space, options);
}

PlacedSpace placeSpace(const SpaceOptions& options, const FractalSpace* fitted) {
  FractalSpace space;
  if (fitted && options.kind == SpaceKind::Fit) space = *fitted;
  space.centre += options.at * space.scale;
  return shifted(space, options);
}

}  // namespace vdbtools
