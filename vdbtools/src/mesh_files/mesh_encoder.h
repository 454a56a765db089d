// SPDX-License-Identifier: Apache-2.0
/// @file mesh_encoder.h
/// The bytes of mesh files: a header, then the parts with points, normals and triangles, in this order. The bytes of a
/// part do not depend on the pieces in which it was encoded.
#pragma once

#include "files/scratch_file.h"
#include "mesh_files/glb_layout.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// The prefix of this project's comments.
inline constexpr std::string_view kCommentMark = "juliavdb ";
/// What precedes the unit in the title of an STL.
inline constexpr std::string_view kStlUnit = "JuliaVDB, unit ";

/// A part of a file on its way into the stream: directly, or through a scratch file until everything before it is
/// complete.
class MeshPart {
 public:
  static constexpr std::size_t kLongestRecord = 4096;  ///< bytes

  explicit MeshPart(std::ostream& stream, std::unique_ptr<ScratchFile> aside = nullptr);

  /// Adds @a count records: @a encode(to, i) writes the i-th one at @a to and returns its end.
  /// @throw IoError  writing to the scratch file failed; the stream's owner must check the stream for errors
  template <class Encode>
  void add(std::size_t count, const Encode& encode) {
    char* end = mBytes.get() + mSize;
    for (std::size_t i = 0; i < count; ++i) {
      end = encode(end, i);
      if (end < mBytes.get() + kChunkSize) continue;
      flush(end);
      end = mBytes.get();
    }
    mSize = static_cast<std::size_t>(end - mBytes.get());
  }

  /// Moves all of it into the stream. @throw IoError
  void finish();

 private:
  /// A stream call for each record would cost more than the encoding.
  static constexpr std::size_t kChunkSize = std::size_t{1} << 20;

  void flush(const char* end);

  std::ostream& mStream;
  std::unique_ptr<ScratchFile> mAside;
  std::unique_ptr<char[]> mBytes;
  std::size_t mSize = 0;
};

class MeshEncoder {
 public:
  /// @throw std::invalid_argument  a voxel size without a box, more columns than a record can hold, an STL of an object
  ///                               that is so small and so far from the origin that its floats would deform it
  explicit MeshEncoder(const MeshWriteOptions& options);

  MeshFormat format() const { return mOptions.format; }
  bool hasNormals() const { return mNormals; }
  bool hasDoubles() const { return mDoubles; }
  /// The number of values in a row.
  std::size_t rowLength() const { return mRowLength; }
  /// Call before header() and encodePoints().
  void setNormals(bool normals) { mNormals = mGlb.normals = normals; }

  // Collects what a header states about points and triangles, which only GLB needs. All of them must be surveyed before
  // header() is called, and encoded in the same order.
  void survey(const PointBatch& batch);
  void survey(std::span<const openvdb::Vec3I> triangles);
  /// The number of the triangles that a file stores. An STL has no points but the corners of its triangles; it omits
  /// triangles with two corners that coincide in 32-bit floats, so the surface stays closed.
  std::uint64_t countOf(std::span<const openvdb::Vec3I> triangles, std::span<const openvdb::Vec3d> points,
                        std::uint64_t firstPoint) const;
  /// Makes the levels of detail.
  void finishSurvey();
  const std::vector<MeshLevel>& levels() const { return mMadeLevels; }

  /// @throw DataError              more points than triangles can refer to
  /// @throw std::invalid_argument  more triangles than the format can count
  void requireCounts(std::uint64_t points, std::uint64_t triangles) const;

  /// Its length does not depend on the counts.
  std::string header(std::uint64_t points, std::uint64_t triangles) const;
  bool headerHasCounts() const { return format() != MeshFormat::Obj; }

  void encodePoints(const PointBatch& batch, MeshPart& part) const;
  /// The texture coordinates of OBJ.
  void encodeCoordinates(const PointBatch& batch, MeshPart& part) const;
  void encodeNormals(const PointBatch& batch, MeshPart& part) const;
  /// @param points  those from @a firstPoint on; needed in STL only
  void encodeTriangles(std::span<const openvdb::Vec3I> triangles, std::span<const openvdb::Vec3d> points,
                       std::uint64_t firstPoint, MeshPart& part) const;
  /// Encodes what follows the triangles.
  void encodeLevels(MeshPart& part) const;

 private:
  template <class Real>
  void encodePlyPoints(const PointBatch& batch, MeshPart& part) const;
  GlbContent contentOf(std::uint64_t points, std::uint64_t triangles) const;
  char* putRow(char* to, const float* row) const;
  /// The offset of the first column of the kind in a row.
  std::optional<std::size_t> offsetOf(ColumnKind kind) const;

  MeshWriteOptions mOptions;
  std::size_t mRowLength;
  std::optional<std::size_t> mColour, mCoordinates;  ///< for OBJ: their offsets in a row
  bool mDoubles = false;
  bool mNormals = false;
  GlbContent mGlb;                     ///< in the unit of the file
  std::vector<MeshLevel> mMadeLevels;  ///< world units
  bool mSurveyed = false;              ///< whether any point was surveyed
  // For a GLB with levels of detail.
  std::vector<float> mPositions;
  std::vector<openvdb::Vec3I> mTriangles;
  std::vector<std::vector<openvdb::Vec3I>> mLevels;
};

}  // namespace vdbtools
