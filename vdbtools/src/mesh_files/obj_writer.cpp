// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_comments.h"
#include "mesh_files/mesh_encoder.h"
#include "mesh_files/mesh_formats.h"

#include "base/srgb.h"

namespace vdbtools {
namespace {

constexpr const char* kObjComment = "# ";

/// Numbers of a line, each preceded by a blank.
template <class Number>
char* putNumbers(char* to, const Number* numbers, int count) {
  for (int i = 0; i < count; ++i) {
    *to++ = ' ';
    to = putNumber(to, numbers[i]);
  }
  return to;
}

class ObjEncoder final : public MeshEncoder {
 public:
  explicit ObjEncoder(const MeshWriteOptions& options)
      : MeshEncoder(options),
        mColour(offsetOf(ColumnKind::LinearRgb)),
        mCoordinates(offsetOf(ColumnKind::TextureCoordinate)) {}

  MeshParts parts() const override { return {.points = true, .coordinates = true, .normals = true}; }
  std::string header(std::uint64_t, std::uint64_t) const override {
    return commentLines(kObjComment, options().comments);
  }
  bool headerHasCounts() const override { return false; }

  void encodePoints(const PointBatch& batch, MeshPart& part) const override {
    part.add(batch.positions.size(), [&](char* to, std::size_t i) {
      to = putNumbers(putText(to, "v"), batch.positions[i].asPointer(), 3);
      if (mColour) {
        // As many digits as a byte needs, like the colours of pictures and of PLY.
        constexpr float kWhite = 255;
        float codes[3];
        for (std::size_t k = 0; k < 3; ++k) codes[k] = srgbCode(batch.values[i * rowLength() + *mColour + k]) / kWhite;
        to = putNumbers(to, codes, 3);
      }
      return putText(to, "\n");
    });
  }

  void encodeCoordinates(const PointBatch& batch, MeshPart& part) const override {
    if (!mCoordinates) return;
    part.add(batch.positions.size(), [&](char* to, std::size_t i) {
      return putText(putNumbers(putText(to, "vt"), &batch.values[i * rowLength() + *mCoordinates], 2), "\n");
    });
  }

  void encodeNormals(const PointBatch& batch, MeshPart& part) const override {
    part.add(batch.normals.size(), [&](char* to, std::size_t i) {
      return putText(putNumbers(putText(to, "vn"), batch.normals[i].asPointer(), 3), "\n");
    });
  }

  void encodeTriangles(std::span<const openvdb::Vec3I> triangles, std::span<const openvdb::Vec3d>, std::uint64_t,
                       MeshPart& part) const override {
    part.add(triangles.size(), [&](char* to, std::size_t i) {
      *to++ = 'f';
      for (int k = 0; k < 3; ++k) {
        const std::uint64_t index = std::uint64_t{triangles[i][k]} + 1;
        *to++ = ' ';
        to = putNumber(to, index);
        if (mCoordinates) to = putNumber(putText(to, "/"), index);
        if (hasNormals()) to = putNumber(putText(to, mCoordinates ? "/" : "//"), index);
      }
      *to++ = '\n';
      return to;
    });
  }

 private:
  std::optional<std::size_t> mColour, mCoordinates;  ///< their offsets in a row
};

}  // namespace

std::unique_ptr<MeshEncoder> objEncoder(const MeshWriteOptions& options) {
  return std::make_unique<ObjEncoder>(options);
}

FileTexts objTexts(std::istream& stream) { return readCommentLines(stream, kObjComment); }

}  // namespace vdbtools
