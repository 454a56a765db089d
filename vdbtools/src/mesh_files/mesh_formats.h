// SPDX-License-Identifier: Apache-2.0
/// @file mesh_formats.h
/// The formats of meshes: the functions that read and write them, and the table in which each format is a row. A new
/// format is a source with its functions, their declarations here, and a row.
///
/// Readers take the bytes of a file. Each parses its file once, in double precision if the format has it, and checks
/// every count and index against the file's content before using it. An error in a text file names the line.
///
/// Only 3MF and compressed glTF use libraries, for their zip, XML and compression; and FBX, DAE, 3DS and X3D are read
/// by Assimp, which somebody has to trust. OpenMesh's readers (9.0) skip vertex lines that they cannot parse, so that
/// all later indices refer to wrong points; they read a word that is not a number as 0, loop forever on a truncated
/// header, reserve as much as a header requests, read coordinates in single precision, and open other files that the
/// file names.
#pragma once

#include "vdbtools/files/file_format.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools {

class MeshEncoder;

// Whether a file is of a format.
// @param head  its first bytes, 64 KiB or more if it has as many
// @param size  of the whole file, which marks a binary STL

bool beginsAsGlb(std::string_view head, std::uintmax_t size);
bool beginsAsGltf(std::string_view head, std::uintmax_t size);
/// After comments.
bool beginsAsOff(std::string_view head, std::uintmax_t size);
bool beginsAsPly(std::string_view head, std::uintmax_t size);
/// Text or binary.
bool beginsAsStl(std::string_view head, std::uintmax_t size);
bool beginsAs3mf(std::string_view head, std::uintmax_t size);

/// The value of an attribute at a point or a corner for which the file gives none.
inline constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

// Readers. @throw DataError  see readMesh()

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
/// The unit of a 3MF as nameOf() has it (units.h); empty if it is another one. @throw DataError
std::string unitOf3mf(const std::filesystem::path& path, std::string_view contents);
/// Reads FBX, DAE, 3DS or X3D, if trustImporter() allows it: all meshes where the nodes show them, turned such that Y
/// points up. Of skins and animations, it reads the points as the meshes have them. No other file is opened.
Mesh readImported(const std::filesystem::path& path, std::string_view contents);
/// Reads text or binary. Each facet has its own corners; see weldMesh().
Mesh readStl(const std::filesystem::path& path, std::string_view contents);

// Encoders (mesh_encoder.h). @throw std::invalid_argument  see needsDoublePositions()

std::unique_ptr<MeshEncoder> glbEncoder(const MeshWriteOptions& options);
std::unique_ptr<MeshEncoder> objEncoder(const MeshWriteOptions& options);
std::unique_ptr<MeshEncoder> plyEncoder(const MeshWriteOptions& options);
std::unique_ptr<MeshEncoder> stlEncoder(const MeshWriteOptions& options);

// The texts of a file that this project wrote, from its beginning; none of any other. The state of the stream shows
// read errors.

/// The extras of the asset.
FileTexts glbTexts(std::istream& stream);
FileTexts objTexts(std::istream& stream);
FileTexts plyTexts(std::istream& stream);
/// The unit alone.
FileTexts stlTexts(std::istream& stream);
/// The unit, of any file.
FileTexts unitTextOf3mf(std::istream& stream);
/// The same of an FBX and a DAE, if trustImporter() allows it.
FileTexts unitTextOfFbx(std::istream& stream);
FileTexts unitTextOfDae(std::istream& stream);

/// A reader of formats without animations.
template <auto read>
Mesh still(const std::filesystem::path& path, std::string_view contents, const std::optional<MeshMoment>&) {
  return read(path, contents);
}

struct MeshFormat {
  FileFormat facts;
  // Each may be null.
  bool (*begins)(std::string_view head, std::uintmax_t size) = nullptr;
  Mesh (*read)(const std::filesystem::path&, std::string_view contents, const std::optional<MeshMoment>&) = nullptr;
  bool isWelded = false;  ///< after it was read
  std::unique_ptr<MeshEncoder> (*encoder)(const MeshWriteOptions&) = nullptr;
  /// Of a format that is not written in pieces. It takes the coordinates as they are.
  std::string (*encodeWhole)(const Mesh&) = nullptr;
  FileTexts (*texts)(std::istream&) = nullptr;
};

/// The table.
inline const auto& meshRows() {
  static const auto rows = [] {
    using enum FormatColumns;
    // clang-format off
  auto formats = std::to_array<MeshFormat>({
      {.facts = {.extension = ".ply", .name = "PLY", .printed = true, .points = true, .piped = true, .recipe = true,
                 .unit = true, .columns = All, .up = UpAxis::Z},
       .begins = beginsAsPly, .read = still<readPly>, .encoder = plyEncoder, .texts = plyTexts},
      {.facts = {.extension = ".obj", .name = "OBJ", .printed = true, .piped = true, .recipe = true, .unit = true,
                 .columns = Colours, .endsUnmarked = true},
       .read = still<readObj>, .encoder = objEncoder, .texts = objTexts},
      {.facts = {.extension = ".stl", .name = "STL", .printed = true, .unit = true, .up = UpAxis::Z},
       .begins = beginsAsStl, .read = still<readStl>, .isWelded = true, .encoder = stlEncoder, .texts = stlTexts},
      {.facts = {.extension = ".glb", .name = "GLB", .recipe = true, .unit = true, .columns = All, .animations = true,
                 .levels = true, .metresYUp = true, .linearLight = true},
       .begins = beginsAsGlb, .read = readGltf, .isWelded = true, .encoder = glbEncoder, .texts = glbTexts},
      {.facts = {.extension = ".gltf", .name = "glTF", .animations = true, .metresYUp = true, .linearLight = true},
       .begins = beginsAsGltf, .read = readGltf, .isWelded = true},
      {.facts = {.extension = ".3mf", .name = "3MF", .printed = true, .isBuilt = canWrite3mf, .unit = true},
       .begins = beginsAs3mf, .read = still<read3mf>, .encodeWhole = [](const Mesh& mesh) { return encode3mf(mesh); },
       .texts = unitTextOf3mf},
      {.facts = {.extension = ".off", .name = "OFF"},
       .begins = beginsAsOff, .read = still<readOff>},
      {.facts = {.extension = ".fbx", .name = "FBX", .unit = true},
       .read = still<readImported>, .texts = unitTextOfFbx},
      {.facts = {.extension = ".dae", .name = "DAE", .unit = true},
       .read = still<readImported>, .texts = unitTextOfDae},
      {.facts = {.extension = ".3ds", .name = "3DS"}, .read = still<readImported>},
      {.facts = {.extension = ".x3d", .name = "X3D"}, .read = still<readImported>},
  });
    // clang-format on
    for (MeshFormat& format : formats) {
      format.facts.readsMesh = format.read != nullptr;
      format.facts.writesMesh = format.encoder != nullptr;
      format.facts.writesColours = format.encoder && format.facts.columns != FormatColumns::None;
    }
    return formats;
  }();
  return rows;
}

/// The row of a format. @throw std::logic_error  it is none of meshes
const MeshFormat& rowOf(const FileFormat& format);

}  // namespace vdbtools
