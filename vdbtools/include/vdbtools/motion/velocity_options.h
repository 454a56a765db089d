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
