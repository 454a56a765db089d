// SPDX-License-Identifier: Apache-2.0
/// @file made_picture.h
/// Pictures of what is made of a scene: of its mesh before there is a file, and of files. Both are seen by the camera
/// of the page, which is that of the target's coordinates.
#pragma once

#include "explore/job_queue.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

#include <string>

namespace vdbtools::explore {

/// A PNG of the mesh that `fractal` makes of a scene. @throw as meshPicture()
std::string pictureOfMesh(const Scene& scene, const FieldPicture& picture, Monitor& monitor);

/// A PNG of the first mesh among the files, or of the level set where there is none.
/// @throw MissingInputError  the files have gone
/// @throw DataError          they hold no surface
std::string pictureOfMade(const MadeFiles& made, const FieldPicture& picture, Monitor& monitor);

}  // namespace vdbtools::explore
