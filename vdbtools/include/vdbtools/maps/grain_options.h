// SPDX-License-Identifier: Apache-2.0
/// @file grain_options.h
/// The grain of a texture as a recipe describes it: --grain and --grain-turn.
#pragma once

#include "vdbtools/control/control.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/grain/grain.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

struct GrainSettings {
  std::string text;  ///< the value of --grain
  GrainKind kind = GrainKind::Along;
  openvdb::Vec3d towards{0, 0, 0};  ///< for GrainKind::Towards
  // For GrainKind::Given, one of these.
  std::optional<int> uv{};           ///< 0: along which u grows on the target's mesh, 1: along which v does
  std::string attribute{};           ///< vectors at the points of the target's mesh
  std::optional<NamedFile> file{};   ///< a VDB with vectors
  std::vector<std::string> grids{};  ///< of the file; empty: its only grid of vectors
  double scale = 1;                  ///< by which waves are longer, > 0: the magnitude of --texture-scale
  ControlSetting turn{};             ///< degrees
};

std::vector<OptionSpec> grainOptions();
/// nullopt for "none". @throw std::invalid_argument  naming the option
std::optional<GrainSettings> parseGrain(const RecipeReader& reader);
/// Whether a recipe has a grain.
bool hasGrain(const Recipe& recipe);
bool hasGrain(const RecipeReader& reader);

}  // namespace vdbtools
