// SPDX-License-Identifier: Apache-2.0
/// @file ply_reader.h
/// Reading PLY. OpenMesh's reader (9.0) is not used for it: it refuses lists counted by uint, ushort or int8; a face
/// property ahead of the indices, or a second list after them, throws it off; double coordinates come out as floats;
/// and on a file that ends within its header it loops for ever.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <string_view>

namespace vdbtools {

/// @throw DataError  see readMesh()
Mesh readPly(const std::filesystem::path& path, std::string_view contents);

}  // namespace vdbtools
