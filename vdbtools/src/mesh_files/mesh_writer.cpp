// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_files/mesh_writer.h"

#include "mesh_files/mesh_encoder.h"
#include "mesh_files/mesh_formats.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

void requireFits(const PointBatch& batch, std::size_t rowLength) {
  const std::size_t points = batch.positions.size(), normals = batch.normals.size(), values = batch.values.size();
  if (normals != 0 && normals != points)
    throw std::logic_error(std::to_string(normals) + " normals were given for " + std::to_string(points) + " points");
  if (values != points * rowLength)
    throw std::logic_error(std::to_string(values) + " values were given for " + std::to_string(points) +
                           " points, each of which has " + std::to_string(rowLength));
}

/// Checks that triangles use points from @a first to before @a end.
void requirePoints(std::span<const Vec3I> triangles, std::uint64_t first, std::uint64_t end) {
  for (const Vec3I& triangle : triangles)
    for (int k = 0; k < 3; ++k)
      if (triangle[k] < first || triangle[k] >= end)
        throw std::logic_error("a triangle uses point " + std::to_string(triangle[k]) + ", which is not from " +
                               std::to_string(first) + " to before " + std::to_string(end));
}

/// Takes batches to the axes and the unit of the file, one at a time.
class BatchTurner {
 public:
  explicit BatchTurner(const MeshWriteOptions& options)
      : mTurn(options.turn), mScale(options.scale), mColumns(options.columns) {}

  /// The result is valid until the next call.
  PointBatch operator()(const PointBatch& batch) {
    if (!mTurn.turns() && mScale == 1) return batch;
    mPositions.assign(batch.positions.begin(), batch.positions.end());
    mNormals.assign(batch.normals.begin(), batch.normals.end());
    for (Vec3d& position : mPositions) position = mTurn(position) * mScale;
    for (Vec3s& normal : mNormals) normal = mTurn(normal);
    mValues.assign(batch.values.begin(), batch.values.end());
    turnWorldVectors(mValues, mColumns, mTurn, mScale);
    return {mPositions, mNormals, mValues};
  }

 private:
  UpTurn mTurn;
  double mScale;
  std::vector<VertexColumn> mColumns;
  std::vector<Vec3d> mPositions;
  std::vector<Vec3s> mNormals;
  std::vector<float> mValues;
};

/// @throw std::invalid_argument
std::unique_ptr<MeshEncoder> encoderOf(const MeshWriteOptions& options) {
  const MeshFormat& row = rowOf(*options.format);
  if (row.encoder) return row.encoder(options);
  throw std::invalid_argument(std::string(options.format->name) + " is not written in pieces");
}

}  // namespace

void turnWorldVectors(std::span<float> values, std::span<const VertexColumn> columns, const UpTurn& turn,
                      double scale) {
  const std::size_t row = rowLength(columns);
  std::size_t offset = 0;
  for (const VertexColumn& column : columns) {
    if (column.kind == ColumnKind::WorldVector)
      for (std::size_t i = offset; i + 2 < values.size(); i += row) {
        const Vec3d turned = turn(Vec3d(values[i], values[i + 1], values[i + 2])) * scale;
        for (std::size_t k = 0; k < 3; ++k) values[i + k] = static_cast<float>(turned[static_cast<int>(k)]);
      }
    offset += componentsOf(column.kind);
  }
}

std::vector<std::string> columnsLeftOut(const FileFormat& format, std::span<const VertexColumn> columns) {
  const auto fits = [&](ColumnKind kind) {
    switch (format.columns) {
      case FormatColumns::None: return false;
      case FormatColumns::Colours: return kind == ColumnKind::LinearRgb || kind == ColumnKind::TextureCoordinate;
      case FormatColumns::OfVoxels: return kind != ColumnKind::TextureCoordinate;
      case FormatColumns::All: return true;
    }
    throw std::logic_error("a kind of room for columns that does not exist");
  };
  std::vector<std::string> names;
  for (const VertexColumn& column : columns)
    if (!fits(column.kind)) names.push_back(column.name);
  return names;
}

bool needsDoublePositions(const MeshWriteOptions& options) { return encoderOf(options)->needsDoubles(); }

void requireMeshCounts(const MeshWriteOptions& options, bool normals, std::uint64_t points, std::uint64_t triangles) {
  const std::unique_ptr<MeshEncoder> encoder = encoderOf(options);
  encoder->setNormals(normals);
  encoder->requireCounts(points, triangles);
}

std::vector<MeshLevel> writeMesh(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options,
                                 std::span<const float> values) {
  requirePoints(mesh.triangles, 0, mesh.points.size());
  if (const auto encodeWhole = rowOf(*options.format).encodeWhole) {
    if (options.turn.turns() || options.scale != 1) throw std::logic_error("a whole mesh is to be turned or scaled");
    stream << encodeWhole(mesh);
    return {};
  }
  MeshWriteOptions complete = options;
  if (!complete.box) complete.box = boundingBox(mesh);
  const std::unique_ptr<MeshEncoder> made = encoderOf(complete);
  MeshEncoder& encoder = *made;
  BatchTurner turner(options);
  const PointBatch points = turner({mesh.points, mesh.normals, values});
  requireFits(points, encoder.rowLength());
  encoder.setNormals(!mesh.normals.empty());
  encoder.survey(points);
  encoder.survey(mesh.triangles);
  encoder.finishSurvey();
  const std::uint64_t triangles = encoder.countOf(mesh.triangles, points.positions, 0);
  encoder.requireCounts(mesh.points.size(), triangles);
  stream << encoder.header(mesh.points.size(), triangles);
  MeshPart whole(stream);
  encoder.encodePoints(points, whole);
  encoder.encodeCoordinates(points, whole);
  encoder.encodeNormals(points, whole);
  encoder.encodeTriangles(mesh.triangles, points.positions, 0, whole);
  encoder.encodeEnd(whole);
  whole.finish();
  return encoder.levels();
}

struct MeshStreamWriter::State {
  State(std::ostream& target, const std::filesystem::path& folder, const MeshWriteOptions& options)
      : stream(target),
        made(encoderOf(options)),
        encoder(*made),
        turner(options),
        seekable(stream.tellp() != std::ostream::pos_type(-1)),
        mayFollow(seekable || !encoder.headerHasCounts()),
        points(part(encoder.parts().points, folder)),
        coordinates(part(encoder.parts().coordinates, folder)),
        normals(part(encoder.parts().normals, folder)),
        triangles(part(encoder.parts().triangles, folder)) {}

  /// Where the header has its place, the first part that exists goes into the stream as it is made. The others wait.
  MeshPart part(bool exists, const std::filesystem::path& folder) {
    std::unique_ptr<ScratchFile> aside;
    if (exists && !std::exchange(mayFollow, false)) aside = std::make_unique<ScratchFile>(folder);
    return MeshPart(stream, std::move(aside));
  }

  /// Runs one call of the writer. Once a call has thrown, the mesh cannot be completed any more.
  template <class Act>
  void run(const Act& act) {
    if (!usable) throw std::logic_error("a mesh writer was used after it was finished, or after an error");
    usable = false;
    act();
    if (!stream) throw IoError("writing a mesh broke off, because its stream takes no more; is the disk full?");
    usable = true;
  }

  /// Writes what precedes the points, or reserves room for it.
  void begin(bool withNormals) {
    encoder.setNormals(withNormals);
    const std::string header = encoder.header(0, 0);
    if (!encoder.headerHasCounts()) {
      stream << header;
    } else if (seekable) {
      start = stream.tellp();
      stream << std::string(header.size(), ' ');  // an empty header would pass for an empty mesh
    }
  }

  void finish() {
    if (pointCount == 0) begin(false);
    encoder.finishSurvey();
    encoder.encodeEnd(triangles);
    encoder.requireCounts(pointCount, triangleCount);
    const std::string header = encoder.header(pointCount, triangleCount);
    if (encoder.headerHasCounts() && !seekable) stream << header;
    points.finish();
    coordinates.finish();
    normals.finish();
    triangles.finish();
    if (!encoder.headerHasCounts() || !seekable) return;
    const std::ostream::pos_type end = stream.tellp();
    stream.seekp(start) << header;
    stream.seekp(end);
  }

  /// Removes the points that no triangle will use, once there are so many that moving the others does not cost more.
  void trimWindow() {
    const std::uint64_t unused = std::min(firstPoint, pointCount) - windowStart;
    if (2 * unused < window.size()) return;
    window.erase(window.begin(), window.begin() + static_cast<std::ptrdiff_t>(unused));
    windowStart += unused;
  }

  std::ostream& stream;
  std::unique_ptr<MeshEncoder> made;
  MeshEncoder& encoder;
  BatchTurner turner;
  bool seekable;
  bool mayFollow;  ///< whether the next part may go into the stream as it is made
  MeshPart points, coordinates, normals, triangles;
  std::ostream::pos_type start = 0;  ///< of the header
  std::uint64_t pointCount = 0, triangleCount = 0, firstPoint = 0;
  std::vector<Vec3d> window;  ///< points from windowStart on, where triangles need them
  std::uint64_t windowStart = 0;
  bool usable = true;
};

MeshStreamWriter::MeshStreamWriter(std::ostream& stream, const std::filesystem::path& scratchFolder,
                                   const MeshWriteOptions& options)
    : mState(std::make_unique<State>(stream, scratchFolder, options)) {}

MeshStreamWriter::~MeshStreamWriter() = default;

void MeshStreamWriter::addPoints(const PointBatch& unturned) {
  State& s = *mState;
  s.run([&] {
    requireFits(unturned, s.encoder.rowLength());
    if (unturned.positions.empty()) return;
    const PointBatch batch = s.turner(unturned);
    s.encoder.requireCounts(s.pointCount + batch.positions.size(), s.triangleCount);
    if (s.pointCount == 0) s.begin(!batch.normals.empty());
    if (s.encoder.hasNormals() == batch.normals.empty())
      throw std::logic_error("some points of a mesh were given with normals, and some without");
    s.encoder.survey(batch);
    s.encoder.encodePoints(batch, s.points);
    s.encoder.encodeCoordinates(batch, s.coordinates);
    s.encoder.encodeNormals(batch, s.normals);
    s.pointCount += batch.positions.size();
    if (!s.encoder.parts().points) s.window.insert(s.window.end(), batch.positions.begin(), batch.positions.end());
  });
}

void MeshStreamWriter::addTriangles(std::span<const Vec3I> triangles, std::uint64_t firstPoint) {
  State& s = *mState;
  s.run([&] {
    // Checked before any triangle is examined, so those that will be left out count, too.
    s.encoder.requireCounts(s.pointCount, s.triangleCount + triangles.size());
    s.firstPoint = std::max(s.firstPoint, firstPoint);
    requirePoints(triangles, s.firstPoint, s.pointCount);
    s.encoder.survey(triangles);
    s.encoder.encodeTriangles(triangles, s.window, s.windowStart, s.triangles);
    s.triangleCount += s.encoder.countOf(triangles, s.window, s.windowStart);
    if (!s.encoder.parts().points) s.trimWindow();
  });
}

void MeshStreamWriter::finish() {
  mState->run([&] { mState->finish(); });
  mState->usable = false;
}

const std::vector<MeshLevel>& MeshStreamWriter::levels() const { return mState->encoder.levels(); }

}  // namespace vdbtools
