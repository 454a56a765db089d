// SPDX-License-Identifier: Apache-2.0
/// @file mesh_picture.h
/// Pictures of the mesh of a scene, without a file in between.
#pragma once

#include "vdbtools/picture/image.h"
#include "vdbtools/render/preview.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// The picture that `render` makes of the PLY that `fractal` makes of this scene.
/// @throw std::invalid_argument  a view that meshes do not have
/// @throw DataError              there is no surface, or only crumbs have one
/// @throw MemoryError            the mesh will not fit
/// @throw Interrupted
Image meshPicture(const Scene& scene, const ViewOptions& view, const Look& look, Monitor& monitor);

/// Renders the same mesh with the light and the camera of @a picture, in the target's coordinates, whatever axis points
/// up in files. If the recipe colours by clay, the material determines the colour.
/// @throw as above
ShadedImage meshPicture(const Scene& scene, const PreviewOptions& picture, Monitor& monitor);

/// Whether pictures of a mesh show the colours of its points. Points coloured by clay get the colour of the material
/// instead.
bool showsOwnColours(const OutputOptions& output);

/// Checks that pictures of meshes support a view. @throw std::invalid_argument
void requireMeshView(const ViewOptions& view);

/// Estimates the CPU seconds of all threads that the field and the mesh of a scene will take, by making a small part of
/// them.
double estimatedMeshSeconds(const Scene& scene, Monitor& monitor);

}  // namespace vdbtools
