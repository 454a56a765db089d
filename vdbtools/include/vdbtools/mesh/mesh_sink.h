// SPDX-License-Identifier: Apache-2.0
/// @file mesh_sink.h
/// The seam between whoever makes a mesh piece by piece and whoever keeps or writes it, so that a mesh of hundreds of
/// millions of triangles need never be held whole.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace vdbtools {

/// Some of a mesh's points, in the order of their indices.
struct PointBatch {
  std::span<const openvdb::Vec3d> positions;  ///< world units
  std::span<const openvdb::Vec3s> normals{};  ///< of unit length, one for each point; or none, in all batches
  /// Row by row, what columns hold besides (vertex_column.h): one row for each point. Which columns there are is known
  /// to whoever made the sink.
  std::span<const float> values{};
};

/// Takes a mesh in pieces, called by one thread at a time. Pieces may be of any size: the result depends only on what
/// they add up to.
class MeshSink {
 public:
  virtual ~MeshSink() = default;

  /// The next points.
  virtual void addPoints(const PointBatch& batch) = 0;

  /// The next triangles, as indices into all points. Every point that they use has been added before.
  /// @param firstPoint  neither these triangles nor later ones use a point before this one
  virtual void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) = 0;
};

/// Keeps the whole mesh.
class MeshCollector final : public MeshSink {
 public:
  /// @param values  takes those of the columns; nullptr: they are not wanted
  explicit MeshCollector(Mesh& mesh, std::vector<float>* values = nullptr) : mMesh(mesh), mValues(values) {}
  void addPoints(const PointBatch& batch) override {
    mMesh.points.insert(mMesh.points.end(), batch.positions.begin(), batch.positions.end());
    mMesh.normals.insert(mMesh.normals.end(), batch.normals.begin(), batch.normals.end());
    if (mValues) mValues->insert(mValues->end(), batch.values.begin(), batch.values.end());
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t) override {
    mMesh.triangles.insert(mMesh.triangles.end(), triangles.begin(), triangles.end());
  }

 private:
  Mesh& mMesh;
  std::vector<float>* mValues;
};

}  // namespace vdbtools
