// SPDX-License-Identifier: Apache-2.0
/// @file format_readers.h
/// One reader for each mesh format, from the bytes of a file to a mesh. Each parses its file once, in double precision
/// where the format has it, and checks every count and index against what the file holds before using it. An error in a
/// text file names the line.
///
/// No library reads these for us. OpenMesh's readers (9.0) skip vertex lines that they cannot parse, so that all later
/// indices mean other points; they take a word that is no number for 0, loop forever on a truncated header, reserve
/// whatever a header asks for, read coordinates in single precision, and open other files that this one names.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <limits>
#include <string_view>

namespace vdbtools {

/// What a point or a corner has of an attribute of which the file says nothing there.
inline constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

/// @throw DataError  see readMesh()
/// glTF, as .gltf or .glb. Corners that differ in their normal or texture coordinates are points of their own; see
/// weldMesh().
Mesh readGltf(const std::filesystem::path& path, std::string_view contents);
Mesh readObj(const std::filesystem::path& path, std::string_view contents);
Mesh readOff(const std::filesystem::path& path, std::string_view contents);
Mesh readPly(const std::filesystem::path& path, std::string_view contents);
/// Text or binary. The corners of a facet are its own; see weldMesh().
Mesh readStl(const std::filesystem::path& path, std::string_view contents);

}  // namespace vdbtools
