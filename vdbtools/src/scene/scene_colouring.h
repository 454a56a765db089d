// SPDX-License-Identifier: Apache-2.0
/// @file scene_colouring.h
/// The colours of a scene's points, with what the scene's target adds.
#pragma once

#include "vdbtools/render/field_colour.h"
#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// A gradient without a range of its own covers the numbers that occur on the surface, from the 2nd to the 98th
/// percentile. They are taken at places that depend on the map and its target alone, not on voxels or a box, so that
/// pictures, meshes, grids and tiles have the same range. If there are hardly any such places, or all have the same
/// number, the gradient keeps its default range.
///
/// The default range of colours by depth extends from the inner end of the shell to its outer end: the distances from
/// the target between which its surface may lie anywhere. Without a shell it is a tenth of the target's longest side,
/// half of it inside.
/// @throw std::invalid_argument  colours by depth without a target
/// @throw as colouringOf()
FieldColouring sceneColouring(const Scene& scene, const ColourChoice& choice);

}  // namespace vdbtools
