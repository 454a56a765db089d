// SPDX-License-Identifier: Apache-2.0
/// @file adaptive_mesh.h
/// The room `decimation` reduces the number of triangles of meshes. It uses the rooms up to `search`.
///
/// This header makes a mesh with triangles as large as a given deviation allows: large where the surface is flat, and
/// small elsewhere.
///
/// Points are only removed, never moved, so the attributes of the remaining points stay exact. Edges are collapsed in
/// the order of the quadric error [Garland and Heckbert, SIGGRAPH 1997], and closed 2-manifolds stay closed
/// 2-manifolds. Afterwards it is proved that no point of either surface is farther from the other than the bound. Where
/// the proof fails, the mesh is made again with a smaller bound for what is around.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh_sink.h"

#include <cstdint>
#include <vector>

namespace vdbtools {

struct AdaptedMesh {
  std::vector<std::uint32_t> points;      ///< the remaining points of the given mesh, ascending
  std::vector<openvdb::Vec3I> triangles;  ///< indices into points
};

/// The extents stay what they are.
/// @param bound  world units, > 0: the maximum Hausdorff distance between the surfaces. It is proved for the whole
///               surfaces, not only for samples of them
/// @throw std::invalid_argument  a bound that is not positive
/// @throw DataError              an edge of more than two triangles, or of two that run the same way
/// @throw Interrupted
AdaptedMesh adaptedMesh(const Mesh& mesh, double bound, Monitor& monitor);

/// The adapted mesh as one of its own, with positions and triangles alone.
/// @param mesh  the mesh that was adapted
Mesh meshOf(const AdaptedMesh& adapted, const Mesh& mesh);

/// Collects a mesh that arrives in pieces until it is complete, and then passes on the adapted mesh. The remaining
/// points keep their normals and rows of columns.
class AdaptiveMeshSink final : public MeshSink {
 public:
  /// @param next  receives the adapted mesh; must outlive this
  AdaptiveMeshSink(MeshSink& next, double bound) : mNext(next), mBound(bound) {}

  void addPoints(const PointBatch& batch) override;
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override;

  /// Call once, when the mesh is complete.
  /// @throw as adaptedMesh()
  void finish(Monitor& monitor);

  std::uint64_t pointsBefore() const { return mMesh.points.size(); }
  std::uint64_t trianglesBefore() const { return mMesh.triangles.size(); }
  std::uint64_t pointsAfter() const { return mPointsAfter; }
  std::uint64_t trianglesAfter() const { return mTrianglesAfter; }

 private:
  MeshSink& mNext;
  double mBound;
  Mesh mMesh;
  std::vector<float> mValues;
  std::uint64_t mPointsAfter = 0, mTrianglesAfter = 0;
};

}  // namespace vdbtools
