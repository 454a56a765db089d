// SPDX-License-Identifier: Apache-2.0
/// @file velocity_options.h
/// Where the velocities of a target come from, as a recipe says it: --target-before, --target-after and --fps, or the
/// target's own animation.
#pragma once

#include "vdbtools/files/named_file.h"
#include "vdbtools/motion/surface_velocity.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/target/target_input.h"

#include <memory>
#include <optional>
#include <vector>

namespace vdbtools {

inline constexpr const char *kTargetBefore = "target-before", *kTargetAfter = "target-after", *kFps = "fps";

struct VelocityOptions {
  /// The target a frame before and a frame after. Without both, the target's moment is one of its own animation.
  std::optional<NamedFile> before{}, after{};
  double fps = 24;  ///< of these frames, or of the animation
};

std::vector<OptionSpec> velocityOptionSpecs();

/// Whether a recipe asks for velocities.
bool wantsVelocity(const Recipe& recipe);
/// Whether a recipe says where velocities come from, apart from an animation.
bool hasNeighbourFrames(const Recipe& recipe);
/// The frames per second that a recipe has or gets by default. @throw std::invalid_argument
double framesPerSecondOf(const Recipe& recipe);

/// Returns nullopt if velocities are not wanted. @throw std::invalid_argument  there is nothing from which they follow
std::optional<VelocityOptions> parseVelocityOptions(const RecipeReader& reader,
                                                    const std::optional<TargetOptions>& target);

/// @param now  the target's mesh; nullptr if it is a VDB
/// @throw DataError, MissingInputError, IoError  as readMesh() and SurfaceMotion
std::shared_ptr<const SurfaceVelocity> surfaceVelocity(const VelocityOptions& options, const TargetOptions& target,
                                                       const std::shared_ptr<const Mesh>& now, MotionDepth depth);

}  // namespace vdbtools
