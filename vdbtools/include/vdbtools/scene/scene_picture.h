// SPDX-License-Identifier: Apache-2.0
/// @file scene_picture.h
/// Prepares a scene for the renderer: the region that rays go through, and the options of the picture.
#pragma once

#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// The region that rays go through, world units: the requested box, or the whole set.
openvdb::BBoxd pictureRegion(const Scene& scene);

/// The options for the renderer: @a picture with the scene's camera, colours, orbit and dropped axis.
/// @param region  as pictureRegion() has it
/// @param usual   the colours if neither the picture nor the recipe gives any
/// @throw what reading the gradient of the colours throws
FieldRenderOptions pictureOptions(const Scene& scene, const openvdb::BBoxd& region, const FieldPicture& picture,
                                  FieldColour usual = FieldColour::Clay);

}  // namespace vdbtools
