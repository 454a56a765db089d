// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_files/mesh_reader.h"
#include "mesh_files/format_readers.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/utf8.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/importer_trust.h"
#include "vdbtools/mesh_files/point_cloud.h"

#include <string>
#include <string_view>

namespace vdbtools {
namespace {

std::string contentsOf(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(pathToOpen(path), error);
  if (!std::filesystem::exists(status)) throw MissingInputError(path.string() + ": no such file; check its name");
  if (!std::filesystem::is_regular_file(status)) {
    throw MissingInputError(path.string() + ": this is " +
                            (std::filesystem::is_directory(status)
                                 ? "a folder; name a mesh file"
                                 : "not an ordinary file; name a mesh file, or '-' for the standard input"));
  }
  return readWholeFile(path);
}

/// With triangles or without.
Mesh readAny(const std::filesystem::path& path, const std::optional<MeshMoment>& moment) {
  const std::string contents = contentsOf(path);
  const std::string extension = meshExtension(path);
  const bool isGltf = isGltfPath(path);
  const auto reader = extension == ".obj"              ? readObj
                      : extension == ".off"            ? readOff
                      : extension == ".ply"            ? readPly
                      : extension == ".stl"            ? readStl
                      : extension == ".3mf"            ? read3mf
                      : isImportedExtension(extension) ? readImported
                                                       : nullptr;
  if (!reader && !isGltf) {
    throw DataError(path.string() + ": the format '" + extension +
                    "' cannot be read; name a file that ends in .obj, .ply, .stl, .off, .3mf, .glb or .gltf");
  }
  if (contents.empty()) throw DataError(path.string() + ": the file is empty (0 bytes); export the mesh again");

  if (isGltf) return weldMesh(readGltf(path, contents, moment));
  if (moment) throw DataError(path.string() + ": it has no animation, which only a glTF may have");
  Mesh mesh = reader(path, contents);
  return reader == readStl ? weldMesh(mesh) : mesh;
}

constexpr std::size_t kHeadSize = 1 << 16;  ///< bytes; comments may precede what tells a format apart

/// @param head  the first bytes of a file
/// @param size  of the whole file
std::string extensionByContent(std::string_view head, std::uintmax_t size) {
  if (head.starts_with("glTF")) return ".glb";
  if (head.starts_with("PK")) return ".3mf";
  if (isStl(head, size)) return ".stl";
  if (head.starts_with("ply")) return ".ply";
  const std::string_view text = withoutByteOrderMark(head);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '{') return ".gltf";
  return beginsAsOff(head) ? ".off" : ".obj";
}

}  // namespace

std::string meshExtension(const std::filesystem::path& path) {
  if (!isStandardInput(path)) return lowerExtension(path);
  std::string head(kHeadSize, '\0');
  std::ifstream stream = openToRead(path);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(pathToOpen(path), error);
  return extensionByContent(head, error ? 0 : size);
}

Mesh readMesh(const std::filesystem::path& path) { return readMesh(path, std::nullopt); }

Mesh readMesh(const std::filesystem::path& path, const std::optional<MeshMoment>& moment) {
  Mesh mesh = readAny(path, moment);
  if (mesh.triangles.empty()) {
    const std::string points = path.string() + ": it has " + std::to_string(mesh.points.size()) + " points, ";
    if (mesh.points.empty()) throw DataError(points + "and no triangle; export the mesh again");
    throw DataError(points + "but no triangle; export the mesh with its faces, or give the points a radius",
                    Remedy::GivePointsRadius);
  }
  return mesh;
}

Mesh readPoints(const std::filesystem::path& path) { return readPoints(path, std::nullopt); }

Mesh readPoints(const std::filesystem::path& path, const std::optional<MeshMoment>& moment) {
  Mesh mesh = asPoints(readAny(path, moment));
  if (mesh.points.empty()) throw DataError(path.string() + ": there is no point in it; export the points again");
  return mesh;
}

}  // namespace vdbtools
