// SPDX-License-Identifier: Apache-2.0
/// @file motion_options.h
/// How a target moves, as a recipe says it: where its points are at rest (--rest, --rest-frame, --rest-attribute), and
/// where they are a frame before and after (--target-before, --target-after and --fps, or the target's own animation).
#pragma once

#include "vdbtools/files/named_file.h"
#include "vdbtools/motion/surface_motion.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/target/target_input.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

// ---- At rest -------------------------------------------------------------------------------------------------------

/// One of these three has the points at rest.
struct RestOptions {
  std::optional<NamedFile> file{};     ///< a mesh with the target's faces
  std::optional<MeshMoment> moment{};  ///< of the target's own animation
  std::string attribute{};             ///< of the target's points: NAME_x, NAME_y and NAME_z, or NAMEx, NAMEy and NAMEz
  std::shared_ptr<const Mesh> mesh{};  ///< a mesh in memory, for which nothing is read; file->path is its name
  MotionDepth depth = MotionDepth::Stretched;
};

std::vector<OptionSpec> restOptionSpecs();
/// Whether a recipe says where the target's points are at rest.
bool hasRest(const Recipe& recipe);
/// @throw std::invalid_argument  naming the option
std::optional<RestOptions> parseRestOptions(const RecipeReader& reader, const std::optional<TargetOptions>& target);

/// The target at rest, as options of a target of its own.
/// @throw as readMesh(), where the points are an attribute
/// @throw DataError  there is no such attribute, or not all of its values are finite
TargetOptions targetAtRest(const RestOptions& rest, const TargetOptions& target);

// ---- Velocities ----------------------------------------------------------------------------------------------------

inline constexpr const char *kTargetBefore = "target-before", *kTargetAfter = "target-after", *kFps = "fps";

struct VelocityOptions {
  std::optional<NamedFile> before{}, after{};  ///< the target a frame before and a frame after
  bool isAnimated = false;                     ///< whether the target's own animation says it instead
  double fps = 24;                             ///< of these frames, or of the animation

  bool isKnown() const { return before || after || isAnimated; }
};

std::vector<OptionSpec> velocityOptionSpecs();

/// Whether a recipe asks for velocities.
bool wantsVelocity(const Recipe& recipe);
/// Whether a recipe says where velocities come from, apart from an animation.
bool hasNeighbourFrames(const Recipe& recipe);
/// The frames per second that a recipe has or gets by default. @throw std::invalid_argument
double framesPerSecondOf(const Recipe& recipe);

/// Returns nullopt if velocities are not wanted. The recipe of a sequence may leave it to its frames from what they
/// follow.
/// @throw std::invalid_argument  there is nothing that could move
std::optional<VelocityOptions> parseVelocityOptions(const RecipeReader& reader,
                                                    const std::optional<TargetOptions>& target);

/// @param now  the target's mesh; nullptr if it is a VDB
/// @throw DataError, MissingInputError, IoError  as readMesh() and SurfaceMotion
std::shared_ptr<const SurfaceVelocity> surfaceVelocity(const VelocityOptions& options, const TargetOptions& target,
                                                       const std::shared_ptr<const Mesh>& now, MotionDepth depth);

}  // namespace vdbtools
