// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/motion/motion_options.h"

#include "control/control_lattice.h"
#include "recipe/option_rows.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/formats/vdb_file.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace vdbtools {
namespace {

constexpr const char* kRestOptions[] = {"rest", "rest-frame", "rest-attribute"};

/// The rule for options that need the shell about a mesh.
std::string idleWithoutMeshShell(const OptionRun& run) {
  const std::string input = run.text("input");
  if (input.empty()) return "it is for a target that moves, and there is no target; leave it out";
  if (isVdbPath(input))
    return "it is for the points of a mesh, and the target is a VDB; leave it out, or give the mesh";
  if (run.text("map") != "shape-modulus")
    return "it is for --map shape-modulus, whose fractal follows the target; leave it out, or give that map";
  return {};
}

std::string idleWithoutRest(const OptionRun& run) {
  return hasRest(run.recipe) ? idleWithoutMeshShell(run)
                             : "it is for a target that moves, and --rest is not given; leave it out";
}

/// The values of a recipe before they are put together.
struct RestText {
  std::string file{}, attribute{};
  std::optional<double> frame{};
  MotionDepth depth = MotionDepth::Stretched;
};

const OptionRows<RestText>& restRows() {
  static const OptionRows<RestText> rows{
      {{.name = "rest",
        .argument = "MESH",
        .help = "the target's points at rest, as a mesh with the same faces: the fractal is that of this mesh, and it "
                "sticks to the target as it moves",
        .hash = "rest-sha256",
        .idle = idleWithoutMeshShell},
       withoutDefault(text(&RestText::file))},
      {{.name = "rest-frame",
        .argument = "F",
        .help = "the same, at a frame of the target's own animation",
        .idle = idleWithoutMeshShell},
       number(&RestText::frame)},
      {{.name = "rest-attribute",
        .argument = "NAME",
        .help = "the same, as a vector attribute of the target's points, such as Houdini's rest",
        .idle = idleWithoutMeshShell},
       withoutDefault(text(&RestText::attribute))},
      {{.name = "rest-depth",
        .help = "the depth of detail where the surface stretches: stretched, in proportion to it; kept, the same "
                "distance as at rest",
        .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
          return hasRest(recipe) ? std::optional<std::string>("stretched") : std::nullopt;
        },
        .defaultNote = "stretched",
        .idle = idleWithoutRest},
       choice<MotionDepth>(&RestText::depth, {{"stretched", MotionDepth::Stretched}, {"kept", MotionDepth::Kept}})}};
  return rows;
}

}  // namespace

std::vector<OptionSpec> restOptionSpecs() { return restRows().specs(); }

bool hasRest(const Recipe& recipe) {
  return std::any_of(std::begin(kRestOptions), std::end(kRestOptions),
                     [&](const char* option) { return recipe.contains(option); });
}

std::optional<RestOptions> parseRestOptions(const RecipeReader& reader, const std::optional<TargetOptions>& target) {
  const RestText text = restRows().read(reader);
  const char* given = nullptr;
  for (const char* option : kRestOptions) {
    if (!reader.has(option)) continue;
    if (given)
      throw std::invalid_argument(std::string("--") + given + " and --" + option +
                                  " both say where the target's points are at rest; give one of them");
    given = option;
  }
  if (!given) return std::nullopt;
  if (!target)
    throw std::invalid_argument(std::string("--") + given + " is for a target that moves, and there is no target");
  if (!target->mesh && isVdbPath(target->input.path))
    throw std::invalid_argument(std::string("--") + given + " is for the points of a mesh, and the target '" +
                                target->input.path.string() + "' is a VDB; give the mesh");
  RestOptions rest{.depth = text.depth};
  if (reader.has("rest")) {
    rest.file = reader.file("rest");
    if (isVdbPath(rest.file->path)) reader.refuse("rest", "a mesh");
  } else if (text.frame) {
    if (!mayBeAnimated(target->input.path))
      throw std::invalid_argument("--rest-frame is for an animated glTF, and '" + target->input.path.string() +
                                  "' is none; give --rest with a mesh");
    rest.moment = momentOfFrame(reader, *text.frame);
  } else {
    rest.attribute = text.attribute;
  }
  return rest;
}

TargetOptions targetAtRest(const RestOptions& rest, const TargetOptions& target) {
  TargetOptions result = target;
  if (rest.moment) {
    result.moment = rest.moment;
    return result;
  }
  result.moment.reset();
  if (!rest.attribute.empty()) {
    Mesh mesh = target.mesh ? *target.mesh : readMesh(target.input.path, target.moment);
    const std::array<const VertexAttribute*, 3> parts =
        requireVector(mesh, rest.attribute, "--rest-attribute " + rest.attribute);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      openvdb::Vec3d point;
      for (int axis = 0; axis < 3; ++axis)
        point[axis] = static_cast<double>(parts[static_cast<std::size_t>(axis)]->values[i]);
      // Points that no triangle uses may have any value.
      if (point.isFinite()) mesh.points[i] = point;
    }
    mesh.normals.clear();
    result.mesh = std::make_shared<const Mesh>(std::move(mesh));
    result.input.recordedAs = "rest-attribute-sha256";
    result.input.expectedHash.clear();
    return result;
  }
  result.mesh = rest.mesh;
  result.input = rest.file.value();
  return result;
}

}  // namespace vdbtools
