// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_writer.h"

#include "vdbtools/errors.h"
#include "vdbtools/file_bytes.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <ostream>
#include <stdexcept>

namespace vdbtools {
namespace {

static_assert(std::endian::native == std::endian::little, "the writers copy numbers as they lie in memory");

constexpr const char* kCommentMark = "juliavdb ";
// The share of a voxel that rounding may move a vertex by.
constexpr double kPositionTolerance = 1e-3;
constexpr std::size_t kBufferSize = 1 << 16;

/// Collects small pieces; a stream call each would cost more than the formatting.
class Buffer {
 public:
  explicit Buffer(std::ostream& stream) : mStream(stream) { mBytes.reserve(kBufferSize + 256); }
  ~Buffer() { flush(); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  template <class T>
  void raw(const T& value) {
    const char* bytes = reinterpret_cast<const char*>(&value);
    mBytes.append(bytes, sizeof value);
  }
  template <class Number>
  void text(Number value) {
    char digits[32];
    mBytes.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  }
  void text(const char* value) { mBytes += value; }
  void flushIfFull() {
    if (mBytes.size() > kBufferSize) flush();
  }

 private:
  void flush() {
    mStream.write(mBytes.data(), static_cast<std::streamsize>(mBytes.size()));
    mBytes.clear();
  }
  std::ostream& mStream;
  std::string mBytes;
};

bool needsDoubles(const Mesh& mesh, double voxelSize) {
  if (!(voxelSize > 0)) return false;
  double largest = 0;
  for (const openvdb::Vec3d& point : mesh.points)
    largest = std::max({largest, std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
  return largest * std::numeric_limits<float>::epsilon() / 2 > kPositionTolerance * voxelSize;
}

/// A comment stays one line.
std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

void writePly(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options) {
  const bool doubles = needsDoubles(mesh, options.voxelSize);
  const bool normals = !mesh.normals.empty();
  stream << "ply\nformat binary_little_endian 1.0\n";
  for (const auto& [key, value] : options.comments)
    stream << "comment " << kCommentMark << key << ' ' << oneLine(value) << '\n';
  stream << "element vertex " << mesh.points.size() << '\n';
  for (const char* name : {"x", "y", "z"}) stream << "property " << (doubles ? "double " : "float ") << name << '\n';
  if (normals)
    for (const char* name : {"nx", "ny", "nz"}) stream << "property float " << name << '\n';
  stream << "element face " << mesh.triangles.size() << "\nproperty list uchar uint vertex_indices\nend_header\n";
  Buffer buffer(stream);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (doubles)
      for (int axis = 0; axis < 3; ++axis) buffer.raw(mesh.points[i][axis]);
    else
      for (int axis = 0; axis < 3; ++axis) buffer.raw(static_cast<float>(mesh.points[i][axis]));
    if (normals)
      for (int axis = 0; axis < 3; ++axis) buffer.raw(mesh.normals[i][axis]);
    buffer.flushIfFull();
  }
  for (const openvdb::Vec3I& triangle : mesh.triangles) {
    buffer.raw(std::uint8_t{3});
    for (int k = 0; k < 3; ++k) buffer.raw(static_cast<std::uint32_t>(triangle[k]));
    buffer.flushIfFull();
  }
}

void writeObj(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options) {
  for (const auto& [key, value] : options.comments)
    stream << "# " << kCommentMark << key << ' ' << oneLine(value) << '\n';
  Buffer buffer(stream);
  const bool normals = !mesh.normals.empty();
  for (const openvdb::Vec3d& point : mesh.points) {
    buffer.text("v");
    for (int axis = 0; axis < 3; ++axis) {
      buffer.text(" ");
      buffer.text(point[axis]);
    }
    buffer.text("\n");
    buffer.flushIfFull();
  }
  for (const openvdb::Vec3s& normal : mesh.normals) {
    buffer.text("vn");
    for (int axis = 0; axis < 3; ++axis) {
      buffer.text(" ");
      buffer.text(normal[axis]);
    }
    buffer.text("\n");
    buffer.flushIfFull();
  }
  for (const openvdb::Vec3I& triangle : mesh.triangles) {
    buffer.text("f");
    for (int k = 0; k < 3; ++k) {
      buffer.text(" ");
      buffer.text(std::uint64_t{triangle[k]} + 1);
      if (!normals) continue;
      buffer.text("//");
      buffer.text(std::uint64_t{triangle[k]} + 1);
    }
    buffer.text("\n");
    buffer.flushIfFull();
  }
}

void writeStl(std::ostream& stream, const Mesh& mesh) {
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("STL cannot count " + std::to_string(mesh.triangles.size()) +
                                " triangles; write a PLY");
  char header[80] = "JuliaVDB";
  stream.write(header, sizeof header);
  Buffer buffer(stream);
  buffer.raw(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const openvdb::Vec3I& triangle : mesh.triangles) {
    const openvdb::Vec3d& a = mesh.points[triangle[0]];
    openvdb::Vec3d normal = (mesh.points[triangle[1]] - a).cross(mesh.points[triangle[2]] - a);
    const double length = normal.length();
    if (length > 0) normal /= length;
    for (int axis = 0; axis < 3; ++axis) buffer.raw(static_cast<float>(normal[axis]));
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) buffer.raw(static_cast<float>(mesh.points[triangle[k]][axis]));
    buffer.raw(std::uint16_t{0});
    buffer.flushIfFull();
  }
}

}  // namespace

MeshFormat meshFormat(const std::filesystem::path& path) {
  const std::string extension = lowerExtension(path);
  if (extension == ".ply") return MeshFormat::Ply;
  if (extension == ".obj") return MeshFormat::Obj;
  if (extension == ".stl") return MeshFormat::Stl;
  throw std::invalid_argument("'" + path.string() +
                              "' is not a mesh format that can be written; use .ply, .obj or .stl");
}

void writeMesh(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options) {
  switch (options.format) {
    case MeshFormat::Ply: return writePly(stream, mesh, options);
    case MeshFormat::Obj: return writeObj(stream, mesh, options);
    case MeshFormat::Stl: return writeStl(stream, mesh);
  }
}

std::map<std::string, std::string> readMeshComments(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw MissingInputError("cannot open '" + path.string() + "'");
  const std::string extension = lowerExtension(path);
  const std::string ours = extension == ".ply" ? "comment " : "# ";
  std::map<std::string, std::string> comments;
  if (extension != ".ply" && extension != ".obj") return comments;
  const std::string prefix = ours + kCommentMark;
  for (std::string line; std::getline(file, line);) {
    // The comments stand at the head of the file: magic and format before them, geometry after.
    if (line.rfind(prefix, 0) == 0) {
      const std::size_t space = line.find(' ', prefix.size());
      if (space != std::string::npos)
        comments[line.substr(prefix.size(), space - prefix.size())] = line.substr(space + 1);
    } else if (line.rfind("ply", 0) != 0 && line.rfind("format", 0) != 0) {
      break;
    }
  }
  if (file.bad()) throw IoError("reading '" + path.string() + "' broke off");
  return comments;
}

}  // namespace vdbtools
