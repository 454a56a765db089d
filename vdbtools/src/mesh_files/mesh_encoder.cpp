// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_encoder.h"

#include "base/srgb.h"
#include "decimation/simplify.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/length_unit.h"
#include "vdbtools/base/number_text.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

static_assert(std::endian::native == std::endian::little, "the writers copy numbers as they lie in memory");

using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

// The fraction of a voxel by which rounding may move a vertex.
constexpr double kPositionTolerance = 1e-3, kFarTolerance = 1e-4;
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

/// Numbers of an OBJ line, each preceded by a blank.
template <class Number>
char* putNumbers(char* to, const Number* numbers, int count) {
  for (int i = 0; i < count; ++i) {
    *to++ = ' ';
    to = putNumber(to, numbers[i]);
  }
  return to;
}

/// The maximum distance by which rounding to floats moves a point of the box along an axis.
double roundingIn(const openvdb::BBoxd& box) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, -box.min()[axis], box.max()[axis]});
  return largest * std::numeric_limits<float>::epsilon() / 2;
}

/// Whether the box is small compared with its distance from the origin.
bool isFar(const openvdb::BBoxd& box) {
  constexpr double kFar = 4;  // longest sides
  double nearest = 0, longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    nearest = std::max({nearest, box.min()[axis], -box.max()[axis]});
    longest = std::max(longest, box.extents()[axis]);
  }
  return nearest > kFar * longest;
}

/// Far from the origin doubles cost little compared with what they preserve: otherwise vertices around one node of the
/// lattice would coincide there.
bool needsDoubles(const openvdb::BBoxd& box, double voxelSize) {
  return roundingIn(box) > (isFar(box) ? kFarTolerance : kPositionTolerance) * voxelSize;
}

void requireFloatsServe(const openvdb::BBoxd& box, double voxelSize) {
  const double moved = roundingIn(box) / voxelSize;
  if (moved <= kPositionTolerance) return;
  std::ostringstream text;
  text.precision(2);
  text << "STL holds positions as 32-bit floats, which would move vertices of this mesh by up to " << moved
       << " voxels, because its coordinates are so large against the voxels; write .ply, .obj or .glb, or move the "
          "shape nearer to the origin";
  throw std::invalid_argument(text.str());
}

/// The centre of the box, as floats if they are close enough to it, because readers of GLB store the position of a node
/// as floats.
Vec3d middleOf(const openvdb::BBoxd& box, double voxelSize) {
  const Vec3d middle = box.getCenter(), rounded{Vec3s(middle)};
  return roundingIn({box.min() - rounded, box.max() - rounded}) > kFarTolerance * voxelSize ? middle : rounded;
}

/// Keeps a comment in one line.
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

std::string properties(const char* type, std::initializer_list<std::string> names) {
  std::string lines;
  for (const std::string& name : names) lines.append("property ").append(type).append(" ").append(name).append("\n");
  return lines;
}

/// The PLY properties of a column.
std::string propertiesOf(const VertexColumn& column) {
  switch (column.kind) {
    case ColumnKind::Number: return properties("float", {column.name});
    case ColumnKind::Vector: return properties("float", {column.name + "_x", column.name + "_y", column.name + "_z"});
    case ColumnKind::LinearRgb: return properties("uchar", {"red", "green", "blue"});
    case ColumnKind::TextureCoordinate: return properties("float", {"s", "t"});
  }
  throw std::logic_error("a kind of column that does not exist");
}

void encodePlyTriangles(std::span<const Vec3I> triangles, MeshPart& part) {
  part.add(triangles.size(), [triangles](char* to, std::size_t i) {
    to = put(to, std::uint8_t{3});
    return putVector<std::uint32_t>(to, triangles[i]);
  });
}

void encodeGlbTriangles(std::span<const Vec3I> triangles, MeshPart& part) {
  part.add(triangles.size(),
           [triangles](char* to, std::size_t i) { return putVector<std::uint32_t>(to, triangles[i]); });
}

void encodeObjTriangles(std::span<const Vec3I> triangles, bool coordinates, bool normals, MeshPart& part) {
  part.add(triangles.size(), [=](char* to, std::size_t i) {
    *to++ = 'f';
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t index = std::uint64_t{triangles[i][k]} + 1;
      *to++ = ' ';
      to = putNumber(to, index);
      if (coordinates) to = putNumber(putText(to, "/"), index);
      if (normals) to = putNumber(putText(to, coordinates ? "/" : "//"), index);
    }
    *to++ = '\n';
    return to;
  });
}

struct StlCorners {
  StlCorners(const Vec3I& triangle, std::span<const Vec3d> points, std::uint64_t firstPoint)
      : a(points[triangle[0] - firstPoint]), b(points[triangle[1] - firstPoint]), c(points[triangle[2] - firstPoint]) {}

  bool collapse() const {
    const Vec3s p(a), q(b), r(c);
    return p == q || q == r || r == p;
  }

  const Vec3d &a, &b, &c;
};

void encodeStlTriangles(std::span<const Vec3I> triangles, std::span<const Vec3d> points, std::uint64_t firstPoint,
                        MeshPart& part) {
  part.add(triangles.size(), [=](char* to, std::size_t i) {
    const StlCorners corners(triangles[i], points, firstPoint);
    if (corners.collapse()) return to;
    const auto& [a, b, c] = corners;
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
  const MeshEncoder encoder(options);
  return options.format != MeshFormat::Ply || encoder.hasDoubles();  // a GLB subtracts in double precision
}

MeshEncoder::MeshEncoder(const MeshWriteOptions& options)
    : mOptions(options), mRowLength(vdbtools::rowLength(options.columns)) {
  constexpr std::size_t kMostValues = 900;
  if (mRowLength > kMostValues)
    throw std::invalid_argument("a mesh file holds up to " + std::to_string(kMostValues) +
                                " numbers a point besides its position, not " + std::to_string(mRowLength));
  if (options.format == MeshFormat::Obj) {
    mColour = offsetOf(ColumnKind::LinearRgb);
    mCoordinates = offsetOf(ColumnKind::TextureCoordinate);
  }
  if (options.format == MeshFormat::Glb) requireGlbColumns(options);
  if (!(options.voxelSize > 0)) return;
  if (!options.box)
    throw std::invalid_argument("a mesh of voxels of " + shortText(options.voxelSize) +
                                " is to be written without a box; give the box that holds it");
  if (format() == MeshFormat::Stl) requireFloatsServe(*options.box, options.voxelSize);
  mDoubles = needsDoubles(*options.box, options.voxelSize);
  if (mDoubles && format() == MeshFormat::Glb) {
    const openvdb::BBoxd box = options.turn(*options.box);
    mGlb.centre = middleOf({box.min() * options.scale, box.max() * options.scale}, options.voxelSize * options.scale);
  }
}

void MeshEncoder::requireCounts(std::uint64_t points, std::uint64_t triangles) const {
  if (points > kMostUint32)
    throw DataError("the mesh has " + std::to_string(points) + " points or more, and triangles can refer to " +
                    std::to_string(kMostUint32) + " of them; use larger voxels, or several boxes");
  if (format() == MeshFormat::Stl && triangles > kMostUint32)
    throw std::invalid_argument("STL cannot count " + std::to_string(triangles) + " triangles; write a PLY");
  if (format() == MeshFormat::Glb) requireGlbSize(contentOf(points, triangles), mOptions);
}

GlbContent MeshEncoder::contentOf(std::uint64_t points, std::uint64_t triangles) const {
  GlbContent content = mGlb;
  content.points = points;
  content.triangles = triangles;
  return content;
}

void MeshEncoder::survey(const PointBatch& batch) {
  if (format() != MeshFormat::Glb) return;
  for (const Vec3d& point : batch.positions) {
    const Vec3s position(point - mGlb.centre);
    if (!mSurveyed) mGlb.low = mGlb.high = position;
    mSurveyed = true;
    mGlb.low = openvdb::math::minComponent(mGlb.low, position);
    mGlb.high = openvdb::math::maxComponent(mGlb.high, position);
    if (!mOptions.levels.empty()) mPositions.insert(mPositions.end(), position.asPointer(), position.asPointer() + 3);
  }
}

void MeshEncoder::survey(std::span<const Vec3I> triangles) {
  if (format() == MeshFormat::Glb && !mOptions.levels.empty())
    mTriangles.insert(mTriangles.end(), triangles.begin(), triangles.end());
}

std::uint64_t MeshEncoder::countOf(std::span<const Vec3I> triangles, std::span<const Vec3d> points,
                                   std::uint64_t firstPoint) const {
  if (format() != MeshFormat::Stl) return triangles.size();
  return static_cast<std::uint64_t>(std::count_if(triangles.begin(), triangles.end(), [=](const Vec3I& triangle) {
    return !StlCorners(triangle, points, firstPoint).collapse();
  }));
}

void MeshEncoder::finishSurvey() {
  if (format() != MeshFormat::Glb) return;
  for (const double share : mOptions.levels) {
    SimplifiedTriangles level = simplified(mPositions, mTriangles, share);
    mGlb.levels.push_back({level.triangles.size(), level.error});
    mMadeLevels.push_back({level.triangles.size(), level.error / mOptions.scale});
    mLevels.push_back(std::move(level.triangles));
  }
}

std::string MeshEncoder::header(std::uint64_t points, std::uint64_t triangles) const {
  switch (format()) {
    case MeshFormat::Ply: {
      const std::string vertices = std::to_string(points), faces = std::to_string(triangles);
      // Counts come first but are known last; blanks beside a number would confuse strict readers, so this comment
      // fills their unused room. The project's own comments precede it, where readMeshComments() looks for them.
      std::string columns;
      for (const VertexColumn& column : mOptions.columns) columns += propertiesOf(column);
      const std::string filler(kMostDigits + 1 - vertices.size() - faces.size(), '.');
      return "ply\nformat binary_little_endian 1.0\n" + commentLines("comment ", mOptions) + "comment " + filler +
             "\nelement vertex " + vertices + '\n' + properties(mDoubles ? "double" : "float", {"x", "y", "z"}) +
             (mNormals ? properties("float", {"nx", "ny", "nz"}) : "") + columns + "element face " + faces +
             "\nproperty list uchar uint vertex_indices\nend_header\n";
    }
    case MeshFormat::Obj: return commentLines("# ", mOptions);
    case MeshFormat::Glb: return glbHeader(contentOf(points, triangles), mOptions);
    case MeshFormat::Stl: {
      std::string header = "JuliaVDB";
      if (const auto unit = mOptions.comments.find(kLengthUnit); unit != mOptions.comments.end())
        header = std::string(kStlUnit) + unit->second;
      header.resize(kStlTitle + sizeof(std::uint32_t), '\0');
      put(header.data() + kStlTitle, static_cast<std::uint32_t>(triangles));
      return header;
    }
  }
  throw std::logic_error("a mesh format that does not exist");
}

std::optional<std::size_t> MeshEncoder::offsetOf(ColumnKind kind) const {
  std::size_t offset = 0;
  for (const VertexColumn& column : mOptions.columns) {
    if (column.kind == kind) return offset;
    offset += componentsOf(column.kind);
  }
  return std::nullopt;
}

char* MeshEncoder::putRow(char* to, const float* row) const {
  for (const VertexColumn& column : mOptions.columns)
    for (std::size_t k = componentsOf(column.kind); k > 0; --k, ++row)
      to = column.kind == ColumnKind::LinearRgb ? put(to, srgbCode(*row)) : put(to, *row);
  return to;
}

template <class Real>
void MeshEncoder::encodePlyPoints(const PointBatch& batch, MeshPart& part) const {
  part.add(batch.positions.size(), [&](char* to, std::size_t i) {
    to = putVector<Real>(to, batch.positions[i]);
    if (mNormals) to = putVector<float>(to, batch.normals[i]);
    return mRowLength == 0 ? to : putRow(to, &batch.values[i * mRowLength]);
  });
}

void MeshEncoder::encodePoints(const PointBatch& batch, MeshPart& part) const {
  switch (format()) {
    case MeshFormat::Ply: return mDoubles ? encodePlyPoints<double>(batch, part) : encodePlyPoints<float>(batch, part);
    case MeshFormat::Obj:
      return part.add(batch.positions.size(), [&](char* to, std::size_t i) {
        to = putNumbers(putText(to, "v"), batch.positions[i].asPointer(), 3);
        if (mColour) {
          // As many digits as a byte needs, like the colours of pictures and of PLY.
          constexpr float kWhite = 255;
          float codes[3];
          for (std::size_t k = 0; k < 3; ++k) codes[k] = srgbCode(batch.values[i * mRowLength + *mColour + k]) / kWhite;
          to = putNumbers(to, codes, 3);
        }
        return putText(to, "\n");
      });
    case MeshFormat::Glb:
      return part.add(batch.positions.size(), [&](char* to, std::size_t i) {
        to = putVector<float>(to, batch.positions[i] - mGlb.centre);
        if (mNormals) to = putVector<float>(to, batch.normals[i]);
        return mRowLength == 0 ? to : putGlbRow(to, &batch.values[i * mRowLength], mOptions);
      });
    case MeshFormat::Stl: return;
  }
}

void MeshEncoder::encodeCoordinates(const PointBatch& batch, MeshPart& part) const {
  if (!mCoordinates) return;
  part.add(batch.positions.size(), [&](char* to, std::size_t i) {
    return putText(putNumbers(putText(to, "vt"), &batch.values[i * mRowLength + *mCoordinates], 2), "\n");
  });
}

void MeshEncoder::encodeNormals(const PointBatch& batch, MeshPart& part) const {
  if (format() != MeshFormat::Obj) return;
  part.add(batch.normals.size(), [&](char* to, std::size_t i) {
    return putText(putNumbers(putText(to, "vn"), batch.normals[i].asPointer(), 3), "\n");
  });
}

void MeshEncoder::encodeTriangles(std::span<const Vec3I> triangles, std::span<const Vec3d> points,
                                  std::uint64_t firstPoint, MeshPart& part) const {
  switch (format()) {
    case MeshFormat::Ply: return encodePlyTriangles(triangles, part);
    case MeshFormat::Obj: return encodeObjTriangles(triangles, mCoordinates.has_value(), mNormals, part);
    case MeshFormat::Glb: return encodeGlbTriangles(triangles, part);
    case MeshFormat::Stl: return encodeStlTriangles(triangles, points, firstPoint, part);
  }
}

void MeshEncoder::encodeLevels(MeshPart& part) const {
  for (const std::vector<Vec3I>& level : mLevels) encodeGlbTriangles(level, part);
}

}  // namespace vdbtools
