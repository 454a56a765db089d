// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_comments.h"
#include "mesh_files/mesh_encoder.h"
#include "mesh_files/mesh_formats.h"

#include "base/srgb.h"

#include <initializer_list>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Vec3I;

constexpr const char* kPlyComment = "comment ";

std::string properties(const char* type, std::initializer_list<std::string> names) {
  std::string lines;
  for (const std::string& name : names) lines.append("property ").append(type).append(" ").append(name).append("\n");
  return lines;
}

/// The PLY properties of a column.
std::string propertiesOf(const VertexColumn& column) {
  switch (column.kind) {
    case ColumnKind::Number: return properties("float", {column.name});
    case ColumnKind::Vector:
    case ColumnKind::WorldVector:
      return properties("float", {column.name + "_x", column.name + "_y", column.name + "_z"});
    case ColumnKind::LinearRgb: return properties("uchar", {"red", "green", "blue"});
    case ColumnKind::TextureCoordinate: return properties("float", {"s", "t"});
  }
  throw std::logic_error("a kind of column that does not exist");
}

class PlyEncoder final : public MeshEncoder {
 public:
  using MeshEncoder::MeshEncoder;

  bool needsDoubles() const override { return hasDoubles(); }
  MeshParts parts() const override { return {.points = true}; }

  std::string header(std::uint64_t points, std::uint64_t triangles) const override {
    const std::string vertices = std::to_string(points), faces = std::to_string(triangles);
    // Counts come first but are known last; blanks beside a number would confuse strict readers, so a comment fills
    // their unused room. The project's own comments precede it, where readCommentLines() looks for them.
    constexpr std::size_t kMostDigits = 10 + 20;  // of both counts: one of 32 bits, one of 64
    const std::string filler(kMostDigits + 1 - vertices.size() - faces.size(), '.');
    std::string columns;
    for (const VertexColumn& column : options().columns) columns += propertiesOf(column);
    return "ply\nformat binary_little_endian 1.0\n" + commentLines(kPlyComment, options().comments) + kPlyComment +
           filler + "\nelement vertex " + vertices + '\n' +
           properties(hasDoubles() ? "double" : "float", {"x", "y", "z"}) +
           (hasNormals() ? properties("float", {"nx", "ny", "nz"}) : "") + columns + "element face " + faces +
           "\nproperty list uchar uint vertex_indices\nend_header\n";
  }

  void encodePoints(const PointBatch& batch, MeshPart& part) const override {
    hasDoubles() ? encodePoints<double>(batch, part) : encodePoints<float>(batch, part);
  }

  void encodeTriangles(std::span<const Vec3I> triangles, std::span<const openvdb::Vec3d>, std::uint64_t,
                       MeshPart& part) const override {
    part.add(triangles.size(), [triangles](char* to, std::size_t i) {
      to = put(to, std::uint8_t{3});
      return putVector<std::uint32_t>(to, triangles[i]);
    });
  }

 private:
  template <class Real>
  void encodePoints(const PointBatch& batch, MeshPart& part) const {
    part.add(batch.positions.size(), [&](char* to, std::size_t i) {
      to = putVector<Real>(to, batch.positions[i]);
      if (hasNormals()) to = putVector<float>(to, batch.normals[i]);
      return rowLength() == 0 ? to : putRow(to, &batch.values[i * rowLength()]);
    });
  }

  char* putRow(char* to, const float* row) const {
    for (const VertexColumn& column : options().columns)
      for (std::size_t k = componentsOf(column.kind); k > 0; --k, ++row)
        to = column.kind == ColumnKind::LinearRgb ? put(to, srgbCode(*row)) : put(to, *row);
    return to;
  }
};

}  // namespace

std::unique_ptr<MeshEncoder> plyEncoder(const MeshWriteOptions& options) {
  return std::make_unique<PlyEncoder>(options);
}

FileTexts plyTexts(std::istream& stream) { return readCommentLines(stream, kPlyComment); }

}  // namespace vdbtools
