// SPDX-License-Identifier: Apache-2.0
/// @file mesh_comments.h
/// The comments of a PLY or OBJ that this project wrote.
#pragma once

#include <istream>
#include <map>
#include <string>

namespace vdbtools {

/// Reads the comments from the file's beginning, up to the first line that is not a comment of this project. The state
/// of the stream shows read errors.
/// @param extension  ".ply" or ".obj"; for any other nothing is read
std::map<std::string, std::string> readMeshComments(std::istream& stream, const std::string& extension);

}  // namespace vdbtools
