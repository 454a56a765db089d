// SPDX-License-Identifier: Apache-2.0
/// @file target_parts.h
/// What a mesh has besides its surface.
#pragma once

#include "vdbtools/mesh/mesh.h"
#include "vdbtools/scene/scene.h"

namespace vdbtools {

TargetParts partsOf(const Mesh& mesh);

}  // namespace vdbtools
