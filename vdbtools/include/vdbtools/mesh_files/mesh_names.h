// SPDX-License-Identifier: Apache-2.0
/// @file mesh_names.h
/// What the file of a mesh says of its faces that a Mesh does not hold.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools {

/// Each once, in the order in which faces first have them.
struct MeshNames {
  std::vector<std::string> materials{};
  std::vector<std::string> groups{};  ///< and objects
};

/// Of an OBJ file; of other formats nothing is read. The file is taken to be one that readMesh() has read.
/// @throw MissingInputError, IoError
MeshNames readMeshNames(const std::filesystem::path& path);

}  // namespace vdbtools
