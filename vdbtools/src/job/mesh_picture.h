// SPDX-License-Identifier: Apache-2.0
/// @file mesh_picture.h
/// What the mesh of a scene looks like, without a file between the two.
#pragma once

#include "vdbtools/picture/image.h"
#include "vdbtools/render/preview.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// The picture that `render` makes of the PLY that `fractal` makes of this scene.
/// @throw std::invalid_argument  a view that meshes do not have
/// @throw DataError              there is no surface, or none but that of crumbs
/// @throw MemoryError            the mesh will not fit
/// @throw Interrupted
Image meshPicture(const Scene& scene, const ViewOptions& view, const Look& look, Monitor& monitor);

/// The same mesh with a light and a camera of its own, in the target's coordinates, whatever axis points up in files.
/// A recipe in which the colours are clay leaves the colour to the material.
/// @throw as above
ShadedImage meshPicture(const Scene& scene, const PreviewOptions& picture, Monitor& monitor);

/// Whether pictures of a mesh show the colours of its points: those of clay leave the colour to the material.
bool showsOwnColours(const OutputOptions& output);

/// A view that pictures of meshes have, too. @throw std::invalid_argument
void requireMeshView(const ViewOptions& view);

/// What the field and the mesh of a scene will take, about: CPU seconds of all threads. Makes a small part of it.
double estimatedMeshSeconds(const Scene& scene, Monitor& monitor);

}  // namespace vdbtools
