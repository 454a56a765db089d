// SPDX-License-Identifier: Apache-2.0
/// @file target_parts.h
/// What the file of a mesh says besides its surface.
#pragma once

#include "vdbtools/mesh/mesh.h"
#include "vdbtools/scene/scene.h"

#include <filesystem>

namespace vdbtools {

/// @param file  that the mesh was read from; empty: it was in memory
TargetParts partsOf(const Mesh& mesh, const std::filesystem::path& file);

}  // namespace vdbtools
