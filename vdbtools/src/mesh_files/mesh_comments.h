// SPDX-License-Identifier: Apache-2.0
/// @file mesh_comments.h
/// The comments of a PLY or OBJ that this project wrote.
#pragma once

#include <istream>
#include <map>
#include <string>

namespace vdbtools {

/// From the file's beginning. It reads no further than to the first line that is no comment of ours; what cannot be
/// read shows in the state of the stream.
/// @param extension  ".ply" or ".obj"; nothing is read of any other
std::map<std::string, std::string> readMeshComments(std::istream& stream, const std::string& extension);

}  // namespace vdbtools
