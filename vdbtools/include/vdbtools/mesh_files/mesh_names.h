// SPDX-License-Identifier: Apache-2.0
/// @file mesh_names.h
/// Names that the file of a mesh gives its faces and that a Mesh does not hold.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools {

/// Each name occurs once, in the order in which faces first have it.
struct MeshNames {
  std::vector<std::string> materials{};
  std::vector<std::string> groups{};  ///< also the names of objects
};

/// Reads the names of an OBJ file; for other formats it reads nothing. The file must be one that readMesh() has read.
/// @throw MissingInputError, IoError
MeshNames readMeshNames(const std::filesystem::path& path);

}  // namespace vdbtools
