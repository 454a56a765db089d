// SPDX-License-Identifier: Apache-2.0
/// @file format_readers.h
/// One reader for each mesh format, from the bytes of a file to a mesh. Each parses its file once, in double precision
/// if the format has it, and checks every count and index against the file's content before using it. An error in a
/// text file names the line.
///
/// Only 3MF and compressed glTF use libraries, for their zip, XML and compression; and FBX, DAE, 3DS and X3D are read
/// by Assimp, which somebody has to trust. OpenMesh's readers (9.0) skip vertex lines that they cannot parse, so that
/// all later indices refer to wrong points; they read a word that is not a number as 0, loop forever on a truncated
/// header, reserve as much as a header requests, read coordinates in single precision, and open other files that the
/// file names.
#pragma once

#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_animation.h"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools {

/// Whether the bytes begin as an OFF does, after comments.
bool beginsAsOff(std::string_view head);
/// Whether a file is STL, text or binary.
/// @param head  its first bytes, 84 or more if it has as many
/// @param size  of the whole file, which marks a binary one
bool isStl(std::string_view head, std::uintmax_t size);

/// The value of an attribute at a point or a corner for which the file gives none.
inline constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

/// @throw DataError  see readMesh()
/// Reads glTF, as .gltf or .glb. Corners that differ in their normal or texture coordinates become separate points; see
/// weldMesh().
/// @param moment  of an animation; without one the nodes stand as the file says
Mesh readGltf(const std::filesystem::path& path, std::string_view contents,
              const std::optional<MeshMoment>& moment = std::nullopt);
Mesh readObj(const std::filesystem::path& path, std::string_view contents);
Mesh readOff(const std::filesystem::path& path, std::string_view contents);
Mesh readPly(const std::filesystem::path& path, std::string_view contents);
/// Reads what is built, at its places; not supports, nor objects that nothing is built of.
Mesh read3mf(const std::filesystem::path& path, std::string_view contents);
/// The unit of a 3MF as nameOf() has it (length_unit.h); empty if it is another one. @throw DataError
std::string unitOf3mf(const std::filesystem::path& path, std::string_view contents);
/// Reads FBX, DAE, 3DS or X3D, if importer_trust.h allows it: all meshes where the nodes show them, turned such that Y
/// points up. Of skins and animations, it reads the points as the meshes have them. No other file is opened.
Mesh readImported(const std::filesystem::path& path, std::string_view contents);
/// The unit of an FBX or DAE as nameOf() has it (length_unit.h); empty if it is another one, for the other formats, and
/// without trust.
/// @throw DataError
std::string unitOfImported(const std::filesystem::path& path, std::string_view contents);
/// Reads text or binary. Each facet has its own corners; see weldMesh().
Mesh readStl(const std::filesystem::path& path, std::string_view contents);

}  // namespace vdbtools
