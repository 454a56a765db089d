// SPDX-License-Identifier: Apache-2.0
/// @file mesh_sink.h
/// The interface between code that makes a mesh piece by piece and code that stores or writes it, so that a mesh of
/// hundreds of millions of triangles need never be held as a whole.
#pragma once

#include "vdbtools/base/memory.h"
#include "vdbtools/mesh/mesh.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

// Data at the points of meshes other than positions and normals: colours, vectors, numbers, texture coordinates.

enum class ColumnKind {
  Number,
  Vector,             ///< three components, the same in all files
  WorldVector,        ///< three components in the axes and the unit of the positions, with which files change them
  LinearRgb,          ///< a colour: three components, with the primaries of sRGB; 0 to 1
  TextureCoordinate,  ///< two components
};

/// A column of a table whose rows are the points. Its values are floats, as many as it has components.
struct VertexColumn {
  std::string name;
  ColumnKind kind = ColumnKind::Number;
};

constexpr std::size_t componentsOf(ColumnKind kind) {
  switch (kind) {
    case ColumnKind::Number: return 1;
    case ColumnKind::TextureCoordinate: return 2;
    case ColumnKind::Vector:
    case ColumnKind::WorldVector:
    case ColumnKind::LinearRgb: return 3;
  }
  return 0;
}

/// The number of floats per row.
inline std::size_t rowLength(std::span<const VertexColumn> columns) {
  std::size_t length = 0;
  for (const VertexColumn& column : columns) length += componentsOf(column.kind);
  return length;
}

/// A batch of a mesh's points, in the order of their indices.
struct PointBatch {
  std::span<const openvdb::Vec3d> positions;  ///< world units
  std::span<const openvdb::Vec3s> normals{};  ///< unit length, one per point; or empty, in all batches
  /// The values of the other columns, row by row, with one row per point. The sink's creator knows
  /// the columns.
  std::span<const float> values{};
};

/// Takes a mesh in pieces; only one thread at a time calls it. Pieces may be of any size: the result depends only on
/// their concatenation.
class MeshSink {
 public:
  virtual ~MeshSink() = default;

  /// Adds the next points.
  virtual void addPoints(const PointBatch& batch) = 0;

  /// Adds the next triangles, as indices into all points. Every point that they use has been added before.
  /// @param firstPoint  neither these triangles nor later ones use a point before this one
  virtual void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) = 0;
};

/// Keeps the whole mesh. Throws MemoryError as soon as the mesh is known to need more memory than there is.
class MeshCollector final : public MeshSink {
 public:
  /// @param values  receives the values of the columns; nullptr: they are not wanted
  explicit MeshCollector(Mesh& mesh, std::vector<float>* values = nullptr) : mMesh(mesh), mValues(values) {}
  void addPoints(const PointBatch& batch) override {
    append(mMesh.points, batch.positions);
    append(mMesh.normals, batch.normals);
    if (mValues) append(*mValues, batch.values);
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t) override {
    append(mMesh.triangles, triangles);
  }

 private:
  /// While a vector grows, its old contents exist twice.
  template <class Value>
  void append(std::vector<Value>& all, std::span<const Value> more) {
    const std::size_t size = all.size() + more.size();
    if (size > all.capacity()) {
      const std::size_t capacity = std::max(size, 2 * all.capacity());
      requireMemory(static_cast<double>(capacity) * sizeof(Value), MemoryUse::Field,
                    "a mesh of more than " + std::to_string(mMesh.points.size()) + " points");
      all.reserve(capacity);
    }
    all.insert(all.end(), more.begin(), more.end());
  }

  Mesh& mMesh;
  std::vector<float>* mValues;
};

/// Moves a mesh on its way to another sink.
class MovedMeshSink final : public MeshSink {
 public:
  /// @param sink  must outlive this
  MovedMeshSink(const openvdb::Vec3d& offset, MeshSink& sink) : mOffset(offset), mSink(sink) {}
  void addPoints(const PointBatch& batch) override {
    mPositions.assign(batch.positions.begin(), batch.positions.end());
    for (openvdb::Vec3d& position : mPositions) position += mOffset;
    mSink.addPoints({mPositions, batch.normals, batch.values});
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override {
    mSink.addTriangles(triangles, firstPoint);
  }

 private:
  openvdb::Vec3d mOffset;
  MeshSink& mSink;
  std::vector<openvdb::Vec3d> mPositions;
};

}  // namespace vdbtools
