// SPDX-License-Identifier: Apache-2.0
/// @file mesh_encoder.h
/// The bytes of mesh files: a header, then the parts with points, texture coordinates, normals and triangles, in this
/// order. The bytes of a part do not depend on the pieces in which it was encoded. Each format has an encoder of its
/// own in its *_writer.cpp, which mesh_formats.h lists.
#pragma once

#include "files/scratch_file.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

inline constexpr std::uint64_t kMostUint32 = std::numeric_limits<std::uint32_t>::max();

// These write at @a to and return the end of what they have written.

template <class Number>
char* put(char* to, Number value) {
  static_assert(std::endian::native == std::endian::little, "the writers copy numbers as they lie in memory");
  std::memcpy(to, &value, sizeof value);
  return to + sizeof value;
}

inline char* putText(char* to, std::string_view text) { return std::copy(text.begin(), text.end(), to); }

/// As text.
template <class Number>
char* putNumber(char* to, Number value) {
  constexpr int kLongestNumber = 32;
  return std::to_chars(to, to + kLongestNumber, value).ptr;
}

template <class Real, class Vector>
char* putVector(char* to, const Vector& vector) {
  for (int axis = 0; axis < 3; ++axis) to = put(to, static_cast<Real>(vector[axis]));
  return to;
}

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

/// The parts that the files of a format have.
struct MeshParts {
  bool points = false, coordinates = false, normals = false, triangles = true;
};

class MeshEncoder {
 public:
  /// @throw std::invalid_argument  a voxel size without a box, more columns than a record can hold, or an object that
  ///                               the format cannot hold
  explicit MeshEncoder(const MeshWriteOptions& options);
  virtual ~MeshEncoder() = default;
  MeshEncoder(const MeshEncoder&) = delete;
  MeshEncoder& operator=(const MeshEncoder&) = delete;

  bool hasNormals() const { return mNormals; }
  /// The number of values in a row.
  std::size_t rowLength() const { return mRowLength; }
  /// Call before header() and encodePoints().
  void setNormals(bool normals) { mNormals = normals; }
  /// As needsDoublePositions().
  virtual bool needsDoubles() const { return true; }
  /// Without a part for points, triangles are encoded with their corners.
  virtual MeshParts parts() const = 0;

  // Collects what a header states about points and triangles. All of them must be surveyed before header() is called,
  // and encoded in the same order.
  virtual void survey(const PointBatch&) {}
  virtual void survey(std::span<const openvdb::Vec3I>) {}
  /// Makes the levels of detail.
  virtual void finishSurvey() {}
  const std::vector<MeshLevel>& levels() const { return mLevels; }
  /// The number of the triangles that a file stores.
  virtual std::uint64_t countOf(std::span<const openvdb::Vec3I> triangles, std::span<const openvdb::Vec3d> points,
                                std::uint64_t firstPoint) const;

  /// @throw DataError              more points than triangles can refer to
  /// @throw std::invalid_argument  more triangles than the format can count
  virtual void requireCounts(std::uint64_t points, std::uint64_t triangles) const;

  /// If it has counts, its length does not depend on them.
  virtual std::string header(std::uint64_t points, std::uint64_t triangles) const = 0;
  virtual bool headerHasCounts() const { return true; }

  virtual void encodePoints(const PointBatch&, MeshPart&) const {}
  virtual void encodeCoordinates(const PointBatch&, MeshPart&) const {}
  virtual void encodeNormals(const PointBatch&, MeshPart&) const {}
  /// @param points  those from @a firstPoint on; without a part for points only
  virtual void encodeTriangles(std::span<const openvdb::Vec3I> triangles, std::span<const openvdb::Vec3d> points,
                               std::uint64_t firstPoint, MeshPart& part) const = 0;
  /// Encodes what follows the triangles.
  virtual void encodeEnd(MeshPart&) const {}

 protected:
  /// The offset of the first column of the kind in a row.
  std::optional<std::size_t> offsetOf(ColumnKind kind) const;
  /// Whether floats would move vertices too far.
  bool hasDoubles() const { return mDoubles; }
  const MeshWriteOptions& options() const { return mOptions; }

  std::vector<MeshLevel> mLevels;  ///< world units

 private:
  MeshWriteOptions mOptions;
  std::size_t mRowLength;
  bool mDoubles = false;
  bool mNormals = false;
};

// The fraction of a voxel by which rounding may move a vertex.
inline constexpr double kPositionTolerance = 1e-3, kFarTolerance = 1e-4;
/// The maximum distance by which rounding to floats moves a point of the box along an axis.
double roundingIn(const openvdb::BBoxd& box);

}  // namespace vdbtools
