// SPDX-License-Identifier: Apache-2.0
/// @file scene_picture.h
/// A scene before the camera: where its rays go, and what the renderer has to know of it.
#pragma once

#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// Where the rays go, world units: the box that was asked for, or all of the set.
openvdb::BBoxd pictureRegion(const Scene& scene);

/// What the renderer needs: @a picture with the scene's camera, colours, orbit and dropped axis.
/// @param region  as pictureRegion() has it
/// @param usual   the colours where neither the picture nor the recipe says any
/// @throw what reading the gradient of the colours throws
FieldRenderOptions pictureOptions(const Scene& scene, const openvdb::BBoxd& region, const FieldPicture& picture,
                                  FieldColour usual = FieldColour::Clay);

}  // namespace vdbtools
