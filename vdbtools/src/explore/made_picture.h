// SPDX-License-Identifier: Apache-2.0
/// @file made_picture.h
/// Pictures of the mesh of a scene before it is written, and of the files of a job. Both use the camera of the page,
/// which is in the target's coordinates.
#pragma once

#include "explore/job_queue.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

#include <string>

namespace vdbtools::explore {

/// A PNG of the mesh that `fractal` makes of a scene. @throw as meshPicture()
std::string pictureOfMesh(const Scene& scene, const FieldPicture& picture, Monitor& monitor);

/// A PNG of the first mesh among the files, or of the level set if there is no mesh.
/// @throw MissingInputError  the files do not exist any more
/// @throw DataError          they contain no surface
std::string pictureOfMade(const MadeFiles& made, const FieldPicture& picture, Monitor& monitor);

}  // namespace vdbtools::explore
