// SPDX-License-Identifier: Apache-2.0
/// @file look.h
/// The material of a surface and the light that falls on it, as options and as values, common to all renderers of
/// surfaces. Like the camera, they are not part of a fractal's recipe.
#pragma once

#include "vdbtools/picture/image.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <openvdb/Types.h>

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// How a surface reflects light; colours are linear RGB.
struct Material {
  openvdb::Vec3d albedo{0.55, 0.32, 0.21};  ///< the fraction of the light that it scatters diffusely
  openvdb::Vec3d gloss{0.10};               ///< the fraction that it reflects specularly at normal incidence
  double sharpness = 18;                    ///< the exponent of Blinn's lobe; larger is smoother
  /// Whether the surroundings are reflected, more strongly towards the outlines. If not, only the key light is.
  bool mirrors = false;
};

/// The names of the materials.
std::vector<std::string> materialNames();

enum class Backdrop { Neutral, Plain, None };

struct Look {
  Material material{};
  /// The position of the key light in degrees: about the vertical from the viewer, positive to the right, and above the
  /// horizon. It moves with the camera.
  double keyAzimuth = -48, keyElevation = 41;
  double sky = 1;                         ///< the brightness of all light other than the key light, 0 or more
  bool ground = false;                    ///< whether there is a floor under the lowest point that receives shadows
  Backdrop backdrop = Backdrop::Neutral;  ///< None: the background has alpha 0
  openvdb::Vec3d plain{0};                ///< the colour of Backdrop::Plain, linear RGB
  double exposure = 0;                    ///< stops by which the light is brightened
};

/// The options --material, --light, --sky, --ground, --background and --exposure.
std::vector<OptionSpec> lookOptionSpecs();
/// @throw std::invalid_argument naming the option and the value
Look parseLook(const RecipeReader& reader);

}  // namespace vdbtools
