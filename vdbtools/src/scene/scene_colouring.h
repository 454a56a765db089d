// SPDX-License-Identifier: Apache-2.0
/// @file scene_colouring.h
/// The colours of a scene's points, with what the scene's target adds.
#pragma once

#include "vdbtools/render/field_colour.h"
#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// A gradient without a range of its own is spread over the numbers that occur on the surface: from 2 to 98 % of those
/// at places which depend on the map and its target alone, and neither on voxels nor on a box. So pictures, meshes,
/// grids and tiles have the same. Where hardly any place is found, or all have one number, it keeps its usual range.
///
/// The usual range of colours by depth runs from the inner end of the shell to its outer end: the distances from the
/// target between which its surface may lie anywhere. Without a shell it runs over a tenth of the target's longest
/// side, half of it inside.
/// @throw std::invalid_argument  colours by depth without a target
/// @throw as colouringOf()
FieldColouring sceneColouring(const Scene& scene, const ColourChoice& choice);

}  // namespace vdbtools
