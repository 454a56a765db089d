// SPDX-License-Identifier: Apache-2.0
/// @file mesh_sink.h
/// The seam between whoever makes a mesh piece by piece and whoever keeps or writes it, so that a mesh of hundreds of
/// millions of triangles need never be held whole.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <span>

namespace vdbtools {

/// Takes a mesh in pieces, called by one thread at a time. Pieces may be of any size: the result depends only on what
/// they add up to.
class MeshSink {
 public:
  virtual ~MeshSink() = default;

  /// The next points, in the order of their indices.
  /// @param normals  of unit length, one for each point; or empty, in all calls or in none
  virtual void addPoints(std::span<const openvdb::Vec3d> points, std::span<const openvdb::Vec3s> normals) = 0;

  /// The next triangles, as indices into all points. Every point that they use has been added before.
  /// @param firstPoint  neither these triangles nor later ones use a point before this one
  virtual void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) = 0;
};

/// Keeps the whole mesh.
class MeshCollector final : public MeshSink {
 public:
  explicit MeshCollector(Mesh& mesh) : mMesh(mesh) {}
  void addPoints(std::span<const openvdb::Vec3d> points, std::span<const openvdb::Vec3s> normals) override {
    mMesh.points.insert(mMesh.points.end(), points.begin(), points.end());
    mMesh.normals.insert(mMesh.normals.end(), normals.begin(), normals.end());
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t) override {
    mMesh.triangles.insert(mMesh.triangles.end(), triangles.begin(), triangles.end());
  }

 private:
  Mesh& mMesh;
};

}  // namespace vdbtools
