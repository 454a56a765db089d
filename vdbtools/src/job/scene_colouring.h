// SPDX-License-Identifier: Apache-2.0
/// @file scene_colouring.h
/// The colours of a scene's points, with what the scene's target adds.
#pragma once

#include "vdbtools/job/scene.h"
#include "vdbtools/render/field_colour.h"

namespace vdbtools {

/// Colours by depth run from the inner end of the shell to its outer end: the distances from the target between which
/// its surface may lie anywhere. Without a shell they run over a tenth of the target's longest side, half of it inside.
/// @throw std::invalid_argument  colours by depth without a target
/// @throw as colouringOf()
FieldColouring sceneColouring(const Scene& scene, const ColourChoice& choice);

}  // namespace vdbtools
