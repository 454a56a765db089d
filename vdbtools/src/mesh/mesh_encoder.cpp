// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_encoder.h"

#include "vdbtools/base/errors.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

static_assert(std::endian::native == std::endian::little, "the writers copy numbers as they lie in memory");

using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

// The share of a voxel that rounding may move a vertex by.
constexpr double kPositionTolerance = 1e-3;
constexpr std::uint64_t kMostUint32 = std::numeric_limits<std::uint32_t>::max();
// Digits of both counts of a PLY: one of 32 bits, one of 64.
constexpr std::size_t kMostDigits = 10 + 20;
constexpr std::size_t kStlTitle = 80;

template <class Number>
char* put(char* to, Number value) {
  std::memcpy(to, &value, sizeof value);
  return to + sizeof value;
}

char* putText(char* to, std::string_view text) { return std::copy(text.begin(), text.end(), to); }

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

/// A line of OBJ.
template <class Vector>
char* putLine(char* to, std::string_view keyword, const Vector& vector) {
  to = putText(to, keyword);
  for (int axis = 0; axis < 3; ++axis) {
    *to++ = ' ';
    to = putNumber(to, vector[axis]);
  }
  *to++ = '\n';
  return to;
}

bool needsDoubles(const openvdb::BBoxd& box, double voxelSize) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, -box.min()[axis], box.max()[axis]});
  return largest * std::numeric_limits<float>::epsilon() / 2 > kPositionTolerance * voxelSize;
}

/// A comment stays one line.
std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

std::string commentLines(const char* start, const MeshWriteOptions& options) {
  std::string lines;
  for (const auto& [key, value] : options.comments)
    lines.append(start).append(kCommentMark).append(key + ' ' + oneLine(value) + '\n');
  return lines;
}

std::string properties(const char* type, std::initializer_list<const char*> names) {
  std::string lines;
  for (const char* name : names) lines.append("property ").append(type).append(" ").append(name).append("\n");
  return lines;
}

template <class Real>
void encodePlyPoints(std::span<const Vec3d> points, std::span<const Vec3s> normals, MeshPart& part) {
  part.add(points.size(), [points, normals](char* to, std::size_t i) {
    to = putVector<Real>(to, points[i]);
    return normals.empty() ? to : putVector<float>(to, normals[i]);
  });
}

void encodePlyTriangles(std::span<const Vec3I> triangles, MeshPart& part) {
  part.add(triangles.size(), [triangles](char* to, std::size_t i) {
    to = put(to, std::uint8_t{3});
    return putVector<std::uint32_t>(to, triangles[i]);
  });
}

void encodeObjTriangles(std::span<const Vec3I> triangles, bool normals, MeshPart& part) {
  part.add(triangles.size(), [triangles, normals](char* to, std::size_t i) {
    *to++ = 'f';
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t index = std::uint64_t{triangles[i][k]} + 1;
      *to++ = ' ';
      to = putNumber(to, index);
      if (normals) to = putNumber(putText(to, "//"), index);
    }
    *to++ = '\n';
    return to;
  });
}

void encodeStlTriangles(std::span<const Vec3I> triangles, std::span<const Vec3d> points, std::uint64_t firstPoint,
                        MeshPart& part) {
  part.add(triangles.size(), [=](char* to, std::size_t i) {
    const Vec3I& triangle = triangles[i];
    const Vec3d& a = points[triangle[0] - firstPoint];
    const Vec3d& b = points[triangle[1] - firstPoint];
    const Vec3d& c = points[triangle[2] - firstPoint];
    Vec3d normal = (b - a).cross(c - a);
    const double length = normal.length();
    if (length > 0) normal /= length;
    for (const Vec3d& vector : {normal, a, b, c}) to = putVector<float>(to, vector);
    return put(to, std::uint16_t{0});
  });
}

}  // namespace

MeshPart::MeshPart(std::ostream& stream, std::unique_ptr<ScratchFile> aside)
    : mStream(stream),
      mAside(std::move(aside)),
      mBytes(std::make_unique_for_overwrite<char[]>(kChunkSize + kLongestRecord)) {}

void MeshPart::flush(const char* end) {
  const std::string_view bytes(mBytes.get(), static_cast<std::size_t>(end - mBytes.get()));
  if (mAside)
    mAside->append(bytes);
  else
    mStream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void MeshPart::finish() {
  flush(mBytes.get() + mSize);
  mSize = 0;
  if (mAside) mAside->moveTo(mStream);
}

bool needsDoublePositions(const MeshWriteOptions& options) {
  if (options.format != MeshFormat::Ply) return true;
  return MeshEncoder(options).hasDoubles();
}

MeshEncoder::MeshEncoder(const MeshWriteOptions& options) : mOptions(options) {
  if (!(options.voxelSize > 0)) return;
  if (!options.box)
    throw std::invalid_argument("a mesh of voxels of " + std::to_string(options.voxelSize) +
                                " is to be written without a box; give the box that holds it");
  mDoubles = needsDoubles(*options.box, options.voxelSize);
}

void MeshEncoder::requireCounts(std::uint64_t points, std::uint64_t triangles) const {
  if (points > kMostUint32)
    throw DataError("the mesh has " + std::to_string(points) + " points or more, and triangles can refer to " +
                    std::to_string(kMostUint32) + " of them; use larger voxels, or several boxes");
  if (format() == MeshFormat::Stl && triangles > kMostUint32)
    throw std::invalid_argument("STL cannot count " + std::to_string(triangles) + " triangles; write a PLY");
}

std::string MeshEncoder::header(std::uint64_t points, std::uint64_t triangles) const {
  switch (format()) {
    case MeshFormat::Ply: {
      const std::string vertices = std::to_string(points), faces = std::to_string(triangles);
      // Counts are known last, but stand first: what they leave of their room is filled here, as blanks beside a number
      // would confuse strict readers. Our own comments come before, where readMeshComments() looks for them.
      const std::string filler(kMostDigits + 1 - vertices.size() - faces.size(), '.');
      return "ply\nformat binary_little_endian 1.0\n" + commentLines("comment ", mOptions) + "comment " + filler +
             "\nelement vertex " + vertices + '\n' + properties(mDoubles ? "double" : "float", {"x", "y", "z"}) +
             (mNormals ? properties("float", {"nx", "ny", "nz"}) : "") + "element face " + faces +
             "\nproperty list uchar uint vertex_indices\nend_header\n";
    }
    case MeshFormat::Obj: return commentLines("# ", mOptions);
    case MeshFormat::Stl: {
      std::string header = "JuliaVDB";
      header.resize(kStlTitle + sizeof(std::uint32_t), '\0');
      put(header.data() + kStlTitle, static_cast<std::uint32_t>(triangles));
      return header;
    }
  }
  throw std::logic_error("a mesh format that does not exist");
}

void MeshEncoder::encodePoints(std::span<const Vec3d> points, std::span<const Vec3s> normals, MeshPart& part) const {
  switch (format()) {
    case MeshFormat::Ply:
      return mDoubles ? encodePlyPoints<double>(points, normals, part) : encodePlyPoints<float>(points, normals, part);
    case MeshFormat::Obj:
      return part.add(points.size(), [points](char* to, std::size_t i) { return putLine(to, "v", points[i]); });
    case MeshFormat::Stl: return;
  }
}

void MeshEncoder::encodeNormals(std::span<const Vec3s> normals, MeshPart& part) const {
  if (format() != MeshFormat::Obj) return;
  part.add(normals.size(), [normals](char* to, std::size_t i) { return putLine(to, "vn", normals[i]); });
}

void MeshEncoder::encodeTriangles(std::span<const Vec3I> triangles, std::span<const Vec3d> points,
                                  std::uint64_t firstPoint, MeshPart& part) const {
  switch (format()) {
    case MeshFormat::Ply: return encodePlyTriangles(triangles, part);
    case MeshFormat::Obj: return encodeObjTriangles(triangles, mNormals, part);
    case MeshFormat::Stl: return encodeStlTriangles(triangles, points, firstPoint, part);
  }
}

}  // namespace vdbtools
