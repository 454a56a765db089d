// SPDX-License-Identifier: Apache-2.0
/// @file view_options.h
/// What a picture is taken with, as options and as values: its size, the camera, and how a map's set is sampled. These
/// options are no part of a fractal's recipe: they change a picture of a set and not the set. How the set is coloured
/// is part of the recipe (field_colour.h), as its mesh and its grids may have the same colours.
#pragma once

#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/render/field_render.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// Of every shaded picture.
struct ViewOptions {
  int width = 800, height = 800;  ///< pixels
  int samples = 4;                ///< rays per pixel: 1, 4, 9 or 16
  ViewAngles angles;
  std::optional<UpAxis> upAxis;      ///< of the world
  std::optional<openvdb::Vec3d> up;  ///< the direction that is up in the picture, world units; in place of the axis
};

/// --size, --azimuth, --elevation, --fov, --samples, --zoom and --up. @param size  the default, such as "800x800"
std::vector<OptionSpec> viewOptionSpecs(const std::string& size);
/// @throw std::invalid_argument naming the option and the value
ViewOptions parseViewOptions(const RecipeReader& reader);

/// Where the eye is: at a given place, or at angles around the set.
struct FieldView {
  std::optional<openvdb::Vec3d> eye, lookAt, up;  ///< world units
  ViewAngles angles;
  std::optional<UpAxis> upAxis;  ///< of the world, if it was given

  /// What a turntable turns about. @param usual  the axis of the world if none was given
  openvdb::Vec3d axis(UpAxis usual = UpAxis::Y) const { return up.value_or(directionOf(upAxis.value_or(usual))); }

  /// @param region  of the set, world units
  /// @param aspect  width over height
  /// @param usual   the axis of the world if none was given
  /// @throw std::invalid_argument  the eye is where it looks at
  Camera camera(const FieldSource& source, const openvdb::BBoxd& region, double aspect, UpAxis usual = UpAxis::Y) const;
};

/// A picture of a map's set, before there is a set: the camera, the colours, the orbit and the dropped axis are yet to
/// be filled in.
struct FieldPicture {
  FieldView view;
  FieldRenderOptions render;
  std::optional<ColourChoice> colour{};  ///< instead of the recipe's, where the table has --colour
};

/// What a picture of a map's set has beside the options of every picture: --eye, --epsilon and so on.
std::vector<OptionSpec> fieldViewOptionSpecs();
/// All options of a picture of a map's set. @param size  the default of --size
std::vector<OptionSpec> fieldPictureOptionSpecs(const std::string& size);
/// @param given  not completed: what is given decides what may stand beside it
/// @param table  of fieldPictureOptionSpecs(), perhaps with colourOptionSpec() and lookOptionSpecs()
/// @throw std::invalid_argument naming the option and the value
FieldPicture parseFieldPicture(const Recipe& given, const OptionTable& table);

/// All options of a picture, the camera's and the light's: of a map's set, or of meshes and level sets.
/// @param size  the default of --size
std::vector<OptionSpec> pictureOptionSpecs(const std::string& size, bool field);
/// Of the names of options those of what a picture shows: where it is seen from and in which light. The others say how
/// many pixels and samples it has, which is one choice for all pictures of a sequence or of a sheet.
bool isAppearance(const std::string& option);
/// The view @a base with @a given over it: a given place of the eye displaces angles around the set, and these a place.
Recipe overriddenView(Recipe base, const Recipe& given);
/// Complete, for a record of what the picture shows: without the angles that a place of the eye leaves without a
/// meaning.
Recipe completeView(Recipe view, const OptionTable& table);

}  // namespace vdbtools
