// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_files/mesh_reader.h"

#include "mesh_files/mesh_formats.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

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
  const FileFormat* const format = formatOfMesh(path);
  if (!format || !format->readsMesh) {
    throw DataError(path.string() + ": the format '" + lowerExtension(path) +
                    "' cannot be read; name a file that ends in " +
                    formatTexts(meshFormats(), &FileFormat::readsMesh, &FileFormat::extension));
  }
  if (contents.empty()) throw DataError(path.string() + ": the file is empty (0 bytes); export the mesh again");
  if (moment && !format->animations)
    throw DataError(path.string() + ": it has no animation, which only a glTF may have");
  const MeshFormat& row = rowOf(*format);
  Mesh mesh = row.read(path, contents, moment);
  return row.isWelded ? weldMesh(mesh) : mesh;
}

}  // namespace

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

Mesh asPoints(Mesh mesh) {
  mesh.cornerUvs.clear();
  mesh.triangles.clear();
  mesh.triangles.reserve(mesh.points.size());
  for (std::uint32_t p = 0; p < mesh.points.size(); ++p) mesh.triangles.emplace_back(p, p, p);
  return mesh;
}

double pointSpacing(const std::vector<openvdb::Vec3d>& points) {
  constexpr std::size_t kMostAsked = 255;
  if (points.size() < 2) return 0;
  const std::size_t asked = std::min(kMostAsked, points.size());
  std::vector<double> nearest(asked, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < asked; ++i) {
    const std::size_t self = i * points.size() / asked;
    for (std::size_t p = 0; p < points.size(); ++p)
      if (p != self) nearest[i] = std::min(nearest[i], (points[p] - points[self]).lengthSqr());
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(asked / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return std::sqrt(*middle);
}

}  // namespace vdbtools
