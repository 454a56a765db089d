// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/plans.h"

#include "farm/variant_plan.h"
#include "scene/file_hashes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/frames.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/motion/motion_options.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/target/target_input.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace vdbtools::farm {
namespace {

constexpr const char* kTargetFrame = "target-frame";

/// The options of a recipe that name a different file for each frame.
std::vector<std::string> animatedFiles(const Recipe& recipe, const OptionTable& table) {
  std::vector<std::string> names;
  for (const auto& [name, value] : recipe)
    if (const OptionSpec* option = table.find(name, recipe); option && !option->hash.empty() && hasFramePattern(value))
      names.push_back(name);
  return names;
}

/// The number of frames from each frame of a list to the next; 1 if it differs from place to place.
int stepOf(std::vector<int> frames) {
  std::sort(frames.begin(), frames.end());
  if (frames.size() < 2) return 1;
  const int step = frames[1] - frames[0];
  for (std::size_t i = 2; i < frames.size(); ++i)
    if (frames[i] - frames[i - 1] != step) return 1;
  return step;
}

/// Where velocities are wanted and nothing says how the target moves: the inputs of the frames before and after. Those
/// of frames that are not made, which may be beyond the ends, are left out where there is no such file.
/// @param recipe  before the names of its files are those of the frame
Recipe neighbourFrames(const Recipe& recipe, const FramePlanOptions& options, int frame) {
  const auto input = recipe.find("input");
  if (input == recipe.end() || !hasFramePattern(input->second) || !wantsVelocity(recipe) ||
      hasNeighbourFrames(recipe) || (recipe.contains(kTargetFrame) && mayBeAnimated(input->second)))
    return {};
  const int step = stepOf(options.frames);
  Recipe neighbours;
  for (const auto& [name, number] : {std::pair(kTargetBefore, frame - step), std::pair(kTargetAfter, frame + step)}) {
    const std::string file = expandFrame(input->second, number);
    const bool isMade = std::find(options.frames.begin(), options.frames.end(), number) != options.frames.end();
    std::error_code error;
    if (isMade || std::filesystem::is_regular_file(file, error)) neighbours[name] = file;
  }
  if (!neighbours.empty() && step != 1) neighbours[kFps] = numbersText({framesPerSecondOf(recipe) / step});
  return neighbours;
}

std::string nameFor(const FramePlanOptions& options, const OptionTable& table) {
  if (!options.name.empty()) return options.name;
  const auto input = options.base.find("input");
  const std::string name = input != options.base.end() ? stemWithoutFrame(input->second) : table.selected(options.base);
  return name.empty() ? "frame" : name;
}

}  // namespace

void playTarget(FramePlanOptions& options) {
  const auto input = options.base.find("input");
  if (input == options.base.end() || !mayBeAnimated(input->second) || hasFramePattern(input->second)) return;
  const bool isChosen = options.base.contains(kTargetFrame) ||
                        std::any_of(options.keys.begin(), options.keys.end(),
                                    [](const KeyedOption& option) { return option.name == kTargetFrame; });
  // A file that is missing is named with the others.
  std::error_code error;
  if (isChosen || !std::filesystem::is_regular_file(input->second, error)) return;
  if (readAnimations(input->second).empty()) return;
  KeyedOption played{.name = kTargetFrame};
  for (const int frame : options.frames) played.keys[frame] = std::to_string(frame);
  options.keys.push_back(std::move(played));
}

Recipe recipeAt(const FramePlanOptions& options, int frame) {
  const OptionTable table = fractalOptionTable();
  Recipe values = options.given;
  for (const KeyedOption& option : options.keys) values[option.name] = valueAt(option, frame);
  Recipe recipe = overridden(options.base, values, table);
  Recipe files = neighbourFrames(recipe, options, frame);
  for (const std::string& name : animatedFiles(recipe, table)) files[name] = expandFrame(recipe.at(name), frame);
  // Another input displaces its neighbours, but not those of its own.
  for (const char* name : {kTargetBefore, kTargetAfter})
    if (const auto found = recipe.find(name); found != recipe.end()) files.emplace(name, found->second);
  if (!files.empty()) recipe = overridden(recipe, files, table);
  if (options.resolution && hasAutomaticResolution(recipe)) recipe["resolution"] = numbersText({*options.resolution});
  if (options.sdfResolution && hasAutomaticSdfResolution(recipe))
    recipe["sdf-resolution"] = numbersText({*options.sdfResolution});
  if (options.voxelSize) recipe = overridden(recipe, {{"voxel-size", numbersText({*options.voxelSize})}}, table);
  return recipe;
}

namespace {

FractalOptions optionsAt(const FramePlanOptions& options, int frame) {
  return parseFractalOptions(completeRecipe(recipeAt(options, frame), fractalOptionTable()));
}

/// Whether all files of a frame exist.
bool isThere(const FramePlanOptions& options, int frame) {
  const std::vector<NamedFile> files = filesOf(optionsAt(options, frame));
  std::error_code error;
  return std::all_of(files.begin(), files.end(),
                     [&](const NamedFile& file) { return std::filesystem::is_regular_file(file.path, error); });
}

/// The first frame, the middle one, and the last of those that count.
template <class Counts>
std::set<int> sampleFrames(const FramePlanOptions& options, const Counts& counts) {
  std::vector<int> frames;
  for (const int frame : options.frames)
    if (counts(recipeAt(options, frame)) && (options.missingFails || isThere(options, frame))) frames.push_back(frame);
  if (frames.empty()) return {};
  return {frames.front(), frames[frames.size() / 2], frames.back()};
}

void chooseSdfResolution(FramePlanOptions& options, Monitor& monitor) {
  std::vector<TargetOptions> targets;
  for (const int frame : sampleFrames(options, hasAutomaticSdfResolution)) {
    TargetOptions target = optionsAt(options, frame).target.value();
    if (std::find(targets.begin(), targets.end(), target) == targets.end()) targets.push_back(std::move(target));
  }
  if (targets.size() < 2) return;  // each frame chooses the same
  for (const TargetOptions& target : targets) {
    // A file that is missing is named with the others.
    std::error_code error;
    if (!std::filesystem::is_regular_file(target.input.path, error)) continue;
    if (const std::optional<double> chosen = openTarget(target, monitor)->chosenSdfResolution(monitor))
      options.sdfResolution = std::max(*chosen, options.sdfResolution.value_or(0));
  }
}

}  // namespace

void chooseResolution(FramePlanOptions& options, Monitor& monitor) {
  chooseSdfResolution(options, monitor);
  double resolution = 0;
  for (const int frame : sampleFrames(options, hasAutomaticResolution))
    resolution = std::max(resolution, makeScene(optionsAt(options, frame), monitor).chosenResolution->resolution);
  if (resolution > 0) options.resolution = resolution;
}

void requireKeysWithoutPatterns(const FramePlanOptions& options) {
  const auto hasPattern = [](const auto& key) { return hasFramePattern(key.second); };
  for (const KeyedOption& option : options.keys)
    if (std::any_of(option.keys.begin(), option.keys.end(), hasPattern))
      throw std::invalid_argument("a key of --" + option.name +
                                  " is the name of a file for each frame; give the option itself, without keys");
}

Manifest planFrames(const FramePlanOptions& options) {
  requireKeysWithoutPatterns(options);
  std::vector<Variant> variants;
  for (const int frame : options.frames)
    variants.push_back({frame, "frame " + std::to_string(frame), recipeAt(options, frame)});
  return planVariants(PlanKind::Frames, variants, {nameFor(options, fractalOptionTable()), options.makes});
}

struct FrameRecipes::Known {
  FileHashes files;
  struct Looked {
    std::optional<std::size_t> triangles{};  ///< 0: no mesh; empty: the target cannot be opened
    double longestSide = 0;                  ///< world units
  };
  /// What look() has opened: the file, and the moment of its animation, seconds.
  std::map<std::pair<std::filesystem::path, std::optional<double>>, Looked> looked{};
  std::map<int, double> sides{};  ///< of the frames' targets
  std::filesystem::path restPath{};
  std::shared_ptr<const Mesh> rest{};  ///< of restPath
};

FrameRecipes::FrameRecipes(FramePlanOptions options) : mOptions(std::move(options)), mKnown(std::make_unique<Known>()) {
  requireKeysWithoutPatterns(mOptions);
  const OptionTable table = fractalOptionTable();
  FrameInputs files;
  for (const int frame : mOptions.frames) {
    try {
      const FractalOptions fractal = parseFractalOptions(completeRecipe(recipeAt(mOptions, frame), table));
      requireTarget(fractal);
      for (const NamedFile& file : filesOf(fractal)) files.add(file.path, frame);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("frame " + std::to_string(frame) + ": " + error.what());
    }
  }
  if (mOptions.missingFails) files.requireNoneMissing();
  mInputs = files.files();
}

FrameRecipes::~FrameRecipes() = default;

void FrameRecipes::look(int frame, Monitor& monitor) {
  const FractalOptions options = optionsAt(mOptions, frame);
  if (!options.target) return;
  const TargetOptions& target = *options.target;
  Known& known = *mKnown;
  std::shared_ptr<const Mesh> mesh;
  const auto [now, isNew] = known.looked.try_emplace(
      {target.input.path, target.moment ? std::optional(target.moment->seconds) : std::nullopt});
  if (!isNew && !now->second.triangles) return;  // said of the frame that opened it first
  if (isNew) {
    const std::unique_ptr<const TargetInput> input = openTarget(target, monitor);
    mesh = input->mesh();
    now->second = {mesh ? mesh->triangles.size() : 0, longestSide(input->box())};
  }
  known.sides[frame] = now->second.longestSide;
  const std::string name = "the target '" + target.input.path.string() + "'";
  if (mesh && options.rest) {
    const RestOptions& rest = *options.rest;
    if (!rest.file) {
      targetAtRest(rest, target);
    } else {
      if (!known.rest || known.restPath != rest.file->path) {
        known.rest = openTarget(targetAtRest(rest, target), monitor)->mesh();
        known.restPath = rest.file->path;
      }
      requireSameFaces(*mesh, *known.rest,
                       {.other = "--rest '" + known.restPath.string() + "'",
                        .mesh = name,
                        .wayOut = "where the faces change, give the points at rest as an attribute of each frame "
                                  "(--rest-attribute), or leave --rest out"});
    }
  }
  if (!options.velocity) return;
  for (const auto& [file, option] :
       {std::pair(&options.velocity->before, kTargetBefore), std::pair(&options.velocity->after, kTargetAfter)}) {
    if (!*file) continue;
    const std::filesystem::path& path = (*file)->path;
    const auto found = known.looked.find({path, std::nullopt});
    const std::optional<std::size_t> triangles =
        found != known.looked.end() ? found->second.triangles : readMesh(path).triangles.size();
    if (triangles)
      requireSameCount(*now->second.triangles, *triangles,
                       {.other = std::string("--") + option + " '" + path.string() + "'",
                        .mesh = name,
                        .wayOut = "where the faces change, leave velocity out of --attributes"});
  }
}

std::optional<SharedVoxel> FrameRecipes::sharedVoxel(const FramePlanOptions& chosen) const {
  const std::map<int, double>& sides = mKnown->sides;
  std::optional<VoxelChoice> choice;
  std::optional<SharedVoxel> shared;
  bool differ = false;
  double longest = 0;
  for (const int frame : chosen.frames) {
    const auto side = sides.find(frame);
    if (side == sides.end()) continue;
    const FractalOptions options = optionsAt(chosen, frame);
    const VoxelChoice& voxels = options.lattice.voxels;
    if (options.rest || options.lattice.automatic || !voxels.resolution || (choice && *choice != voxels))
      return std::nullopt;
    choice = voxels;
    differ = differ || (shared && side->second != longest);
    if (side->second <= longest) continue;
    longest = side->second;
    shared = SharedVoxel{voxels.sizeFor(longest), frame};
  }
  return differ ? shared : std::nullopt;
}

Recipe FrameRecipes::at(int frame) const {
  Recipe recipe = completeRecipe(recipeAt(mOptions, frame), fractalOptionTable());
  for (const auto& [name, hash] : mKnown->files.of(parseFractalOptions(recipe))) recipe[name] = hash;
  return recipe;
}

}  // namespace vdbtools::farm
