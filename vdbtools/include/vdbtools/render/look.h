// SPDX-License-Identifier: Apache-2.0
/// @file look.h
/// What a surface is made of and the light that falls on it, as options and as values. Every renderer of surfaces has
/// the same. Like the camera, none of it is part of a fractal's recipe.
#pragma once

#include "vdbtools/picture/image.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <openvdb/Types.h>

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// How a surface answers light; colours are linear RGB.
struct Material {
  openvdb::Vec3d albedo{0.55, 0.32, 0.21};  ///< the part of the light that it scatters to all sides
  openvdb::Vec3d gloss{0.10};               ///< the part that it mirrors when it is seen straight on
  double sharpness = 18;                    ///< the exponent of Blinn's lobe: larger is smoother
  /// Whether the surroundings are mirrored, and more of them towards the outlines. If not, only the key light is.
  bool mirrors = false;
};

/// The materials by name: "clay, plaster, ...".
std::string materialNames();

enum class Backdrop { Neutral, Plain, None };

struct Look {
  Material material{};
  /// Where the key light stands: degrees about the vertical from the viewer, positive to the right, and above the
  /// horizon. It goes along with the camera.
  double keyAzimuth = -48, keyElevation = 41;
  double sky = 1;                         ///< the brightness of all light but the key's, 0 or more
  bool ground = false;                    ///< whether there is a floor under the lowest point that takes shadows
  Backdrop backdrop = Backdrop::Neutral;  ///< None: what is behind has alpha 0
  openvdb::Vec3d plain{0};                ///< of Backdrop::Plain, linear RGB
  double exposure = 0;                    ///< stops by which the light is brighter
};

/// --material, --light, --sky, --ground, --background and --exposure.
std::vector<OptionSpec> lookOptionSpecs();
/// @throw std::invalid_argument naming the option and the value
Look parseLook(const RecipeReader& reader);

}  // namespace vdbtools
