// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/motion/motion_options.h"

#include "recipe/option_rows.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools {
namespace {

std::string idleWithoutVelocity(const OptionRun& run) {
  return wantsVelocity(run.recipe) ? ""
                                   : "it is for --attributes velocity, which is not given; give that, or leave it out";
}

std::string idleWithoutNeighbours(const OptionRun& run) {
  if (hasNeighbourFrames(run.recipe)) return {};
  return "it is for --target-before and --target-after, and neither is given (an animated glTF has --target-fps); "
         "leave "
         "it out";
}

/// The values of a recipe before they are put together.
struct VelocityText {
  std::string before{}, after{};
  double fps = VelocityOptions{}.fps;
};

const OptionRows<VelocityText>& velocityRows() {
  const IdleRule idle =
      idleByAny({idleWithoutVelocity, idleWithout({Product::Vdb, Product::Mesh, Product::Stl, Product::Glb},
                                                  "the points of a mesh or a VDB")});
  static const OptionRows<VelocityText> rows{
      {{.name = kTargetBefore,
        .argument = "MESH",
        .help = "the target one frame earlier, a mesh with the same faces, from which --attributes velocity follows",
        .hash = "target-before-sha256",
        .idle = idle},
       withoutDefault(text(&VelocityText::before))},
      {{.name = kTargetAfter,
        .argument = "MESH",
        .help =
            "the target one frame later; one of the two is enough. With --frames, where the input's name has a place "
            "for the frame, both are that input by default, at the neighbouring frames",
        .hash = "target-after-sha256",
        .idle = idle},
       withoutDefault(text(&VelocityText::after))},
      {{.name = kFps,
        .argument = "N",
        .help = "frames per second of --target-before and --target-after; velocities are lengths per second",
        .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
          return hasNeighbourFrames(recipe) ? std::optional(numbersText({VelocityOptions{}.fps})) : std::nullopt;
        },
        .defaultNote = numbersText({VelocityOptions{}.fps}),
        .idle = idleByAny({idle, idleWithoutNeighbours})},
       number(&VelocityText::fps, above(0))}};
  return rows;
}

/// When an animation moves, from its first key to its last, seconds.
std::pair<double, double> timesOf(const std::filesystem::path& path, const std::string& name) {
  std::pair<double, double> times{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  const std::vector<MeshAnimation> all = readAnimations(path);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool isPlayed = name.empty() ? i == 0 : name == "all" || name == all[i].name || name == std::to_string(i);
    if (!isPlayed) continue;
    times.first = std::min(times.first, all[i].first);
    times.second = std::max(times.second, all[i].last);
  }
  return times;
}

/// The moments of an animation a frame before and a frame after, as far as it goes.
std::vector<SurfaceAt> momentsAround(const TargetOptions& target, double frame) {
  const MeshMoment& now = target.moment.value();
  const auto [first, last] = timesOf(target.input.path, now.animation);
  std::vector<SurfaceAt> moments;
  if (!(first < last)) return moments;
  const auto within = [from = first, to = last](double seconds) { return std::clamp(seconds, from, to); };
  const double before = within(now.seconds - frame), after = within(now.seconds + frame);
  if (!(before < after)) return moments;
  for (const double seconds : {before, after}) {
    if (seconds == within(now.seconds)) continue;
    const MeshMoment moment{seconds, now.animation};
    moments.push_back({.seconds = seconds - within(now.seconds),
                       .mesh = std::make_shared<const Mesh>(readMesh(target.input.path, moment)),
                       .name = "the target at another moment"});
  }
  return moments;
}

}  // namespace

std::vector<OptionSpec> velocityOptionSpecs() { return velocityRows().specs(); }

bool wantsVelocity(const Recipe& recipe) {
  const auto found = recipe.find("attributes");
  if (found == recipe.end()) return false;
  const std::vector<std::string> names = split(found->second, ',');
  return std::find(names.begin(), names.end(), "velocity") != names.end();
}

bool hasNeighbourFrames(const Recipe& recipe) {
  return recipe.contains(kTargetBefore) || recipe.contains(kTargetAfter);
}

double framesPerSecondOf(const Recipe& recipe) {
  const auto found = recipe.find(kFps);
  if (found == recipe.end()) return VelocityOptions{}.fps;
  const double fps = parseNumber(kFps, found->second);
  if (!above(0).holds(fps)) refuse(kFps, found->second, "above 0");
  return fps;
}

std::optional<VelocityOptions> parseVelocityOptions(const RecipeReader& reader,
                                                    const std::optional<TargetOptions>& target) {
  const VelocityText text = velocityRows().read(reader);
  for (const char* name : {kTargetBefore, kTargetAfter})
    if (reader.has(name) && !target)
      throw std::invalid_argument("--" + std::string(name) + " is for a target that moves, and there is no target");
  if (!wantsVelocity(reader.recipe())) return std::nullopt;
  if (!target) reader.refuse("attributes", "without 'velocity', as there is no target that could move");
  if (!target->mesh && isVdbPath(target->input.path))
    reader.refuse("attributes", "without 'velocity', as the target '" + target->input.path.string() +
                                    "' is a VDB, which has no points that could move; give the mesh");
  VelocityOptions options{.fps = text.fps};
  const auto fileOf = [&](const char* name) -> std::optional<NamedFile> {
    if (!reader.has(name)) return std::nullopt;
    if (isVdbPath(reader.text(name))) reader.refuse(name, "a mesh");
    return reader.file(name);
  };
  options.before = fileOf(kTargetBefore);
  options.after = fileOf(kTargetAfter);
  options.isAnimated = !options.before && !options.after && target->moment;
  if (options.isAnimated) options.fps = 1 / momentOfFrame(reader, 1).seconds;
  return options;
}

std::shared_ptr<const SurfaceVelocity> surfaceVelocity(const VelocityOptions& options, const TargetOptions& target,
                                                       const std::shared_ptr<const Mesh>& now, MotionDepth depth) {
  if (!now) throw DataError("the target is a VDB, which has no points that could move; give it as a mesh");
  const double frame = 1 / options.fps;
  std::vector<SurfaceAt> moments;
  const auto add = [&](const std::optional<NamedFile>& file, const char* option, double seconds) {
    if (!file) return;
    moments.push_back({.seconds = seconds,
                       .mesh = std::make_shared<const Mesh>(readMesh(file->path)),
                       .name = "--" + std::string(option) + " '" + file->path.string() + "'"});
  };
  add(options.before, kTargetBefore, -frame);
  add(options.after, kTargetAfter, frame);
  if (options.isAnimated) moments = momentsAround(target, frame);
  return std::make_shared<const SurfaceVelocity>(*now, moments, depth);
}

}  // namespace vdbtools
