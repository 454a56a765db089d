// SPDX-License-Identifier: Apache-2.0
/// @file target_parts.h
/// What the file of a mesh contains besides its surface.
#pragma once

#include "vdbtools/mesh/mesh.h"
#include "vdbtools/scene/scene.h"

#include <filesystem>

namespace vdbtools {

/// @param file  the file from which the mesh was read; empty: the mesh was in memory
TargetParts partsOf(const Mesh& mesh, const std::filesystem::path& file);

}  // namespace vdbtools
