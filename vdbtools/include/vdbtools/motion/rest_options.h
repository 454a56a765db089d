// SPDX-License-Identifier: Apache-2.0
/// @file rest_options.h
/// Where the points of a moving target are at rest, as a recipe says it: --rest, --rest-frame and --rest-attribute.
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

}  // namespace vdbtools
