// SPDX-License-Identifier: Apache-2.0
/// @file view_options.h
/// How a picture is taken, as options and as values: its size, the camera, and how a map's set is sampled. These
/// options are not part of a fractal's recipe: they change a picture of a set and not the set. The colouring of the set
/// is part of the recipe (field_colour.h), because its mesh and its grids may have the same colours.
#pragma once

#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/render/field_render.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// The options common to all shaded pictures.
struct ViewOptions {
  int width = 800, height = 800;  ///< pixels
  int samples = 4;                ///< rays per pixel: 1, 4, 9 or 16
  ViewAngles angles;
  std::optional<UpAxis> upAxis;      ///< the world's up axis
  std::optional<openvdb::Vec3d> up;  ///< the direction that is up in the picture, world units; it replaces the axis
};

/// The options --size, --azimuth, --elevation, --fov, --samples, --zoom and --up. @param size  the default, such as
/// "800x800"
std::vector<OptionSpec> viewOptionSpecs(const std::string& size);
/// @throw std::invalid_argument naming the option and the value
ViewOptions parseViewOptions(const RecipeReader& reader);

/// The position of the eye: a given point, or angles around the set.
struct FieldView {
  std::optional<openvdb::Vec3d> eye, lookAt, up;  ///< world units
  ViewAngles angles;
  std::optional<UpAxis> upAxis;  ///< the world's up axis, if it was given

  /// The axis of a turntable. @param usual  the axis of the world if none was given
  openvdb::Vec3d axis(UpAxis usual = UpAxis::Y) const { return up.value_or(directionOf(upAxis.value_or(usual))); }

  /// @param region  bounds of the set, world units
  /// @param aspect  width over height
  /// @param usual   the axis of the world if none was given
  /// @throw std::invalid_argument  the eye coincides with the point it looks at
  Camera camera(const FieldSource& source, const openvdb::BBoxd& region, double aspect, UpAxis usual = UpAxis::Y) const;
};

/// A picture of a map's set, before the set is known: the camera, the colours, the orbit and the dropped axis are
/// filled in later.
struct FieldPicture {
  FieldView view;
  FieldRenderOptions render;
  std::optional<ColourChoice> colour{};  ///< replaces the recipe's colours, if the table has --colour
};

/// The options of a picture of a map's set in addition to those of every picture: --eye, --epsilon and so on.
std::vector<OptionSpec> fieldViewOptionSpecs();
/// All options of a picture of a map's set. @param size  the default of --size
std::vector<OptionSpec> fieldPictureOptionSpecs(const std::string& size);
/// @param given  without defaults, because some options exclude others only if they were given
/// @param table  the table of fieldPictureOptionSpecs(), perhaps with colourOptionSpec() and lookOptionSpecs()
/// @throw std::invalid_argument naming the option and the value
FieldPicture parseFieldPicture(const Recipe& given, const OptionTable& table);

/// All options of a picture, including the camera and the light, for a map's set or for meshes and level sets.
/// @param size  the default of --size
std::vector<OptionSpec> pictureOptionSpecs(const std::string& size, bool field);
/// Whether an option affects what a picture shows, i.e. the viewpoint or the light. The other options set the numbers
/// of pixels and samples, which are the same for all pictures of a sequence or of a sheet.
bool isAppearance(const std::string& option);
/// Overrides the view @a base with @a given: a given eye position replaces angles around the set, and angles replace a
/// position.
Recipe overriddenView(Recipe base, const Recipe& given);
/// Completes a view with defaults, for a record of what the picture shows. Angles are left out if a given eye position
/// makes them meaningless.
Recipe completeView(Recipe view, const OptionTable& table);

}  // namespace vdbtools
