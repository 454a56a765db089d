// SPDX-License-Identifier: Apache-2.0
/// @file extract_mesh.h
/// The room `surface` turns a field into surfaces: a mesh whose vertices lie on the true F = 0, and the level set and
/// other grids that are exported. It uses the rooms up to `field`.
///
/// This header declares marching cubes on the signs of F. The position of each vertex on its lattice edge is found by
/// evaluating the true F, because F is far from linear between nodes ([Kim15], [KD20] Fig. 4).
///
/// The mesh is closed and 2-manifold away from the domain's border, and oriented outward; vertices are shared, one for
/// each crossing edge. On ambiguous faces the inside corners are kept apart. Positions and order depend on global
/// indices only: points and triangles are ordered by the blocks of 8^3 nodes in which their edges and cells begin, and
/// the blocks by x, then y, then z.
#pragma once

#include "vdbtools/field/fractal_field.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"

#include <cstdint>
#include <span>
#include <vector>

namespace vdbtools {

/// What happens where the domain cuts the set.
enum class Border {
  Open,  ///< the mesh ends at the border
  Cap,   ///< flat caps close the set, at FieldPlan::capFaces or half a voxel beyond the last nodes
};

struct ExtractMeshOptions {
  double tolerance = 1e-3;  ///< voxels: a vertex lies within this of a sign change of F; 2^-40 to 0.5
  Border border = Border::Open;
};

/// A whole mesh whose set is closed by caps where the domain cuts it.
struct CappedMesh {
  Mesh mesh;                ///< without normals
  std::vector<bool> onCap;  ///< whether each point lies on an edge that leaves the domain, and therefore on a cap
};

/// The lattice edge on which a point lies.
struct EdgePlace {
  openvdb::Coord node;    ///< the node where the edge begins
  std::uint8_t axis = 0;  ///< the axis along which it runs
  bool cut = false;       ///< whether it leaves the domain, so that the point lies on a cap
};

/// The places of the points and the triangles of a mesh in the lattice.
struct MeshPlaces {
  std::vector<EdgePlace> points;
  std::vector<openvdb::Coord> triangles;  ///< the first nodes of their cells
};

struct PlacedMesh {
  Mesh mesh;
  MeshPlaces places;
};

/// Takes a mesh in pieces, as a MeshSink does, with the places of its points and triangles.
class PlacedMeshSink {
 public:
  virtual ~PlacedMeshSink() = default;

  /// Adds the next points. @param places  of each point
  virtual void addPoints(const PointBatch& batch, std::span<const EdgePlace> places) = 0;

  /// Adds the next triangles, as indices into all points, of cells in one block of 8^3 nodes.
  /// @param block  the first node of the block
  /// @param cells  for each triangle the offset of its cell's first node in the block
  virtual void addTriangles(std::span<const openvdb::Vec3I> triangles, const openvdb::Coord& block,
                            std::span<const std::uint16_t> cells) = 0;
};

struct MeshCounts {
  std::uint64_t points = 0, triangles = 0;
  std::uint64_t evaluatedNodes = 0;     ///< evaluated nodes of the lattice; 0 if the field was evaluated before
  std::optional<CrumbReport> crumbs{};  ///< the crumbs dropped meanwhile, if the plan drops them
};

/// Extracts the whole mesh, without normals.
/// @throw std::invalid_argument  tolerance out of its domain
/// @throw DataError              more points than 32-bit indices count
Mesh extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                 Monitor& monitor);

/// Extracts the mesh with Border::Cap. withoutCaps() derives the open mesh from it without searching the edges again.
/// @throw as extractMesh()
CappedMesh extractCappedMesh(const FractalField& field, const FieldSource& source, double tolerance, Monitor& monitor);

/// Returns the mesh that extractMesh() makes with Border::Open, to the bit.
Mesh withoutCaps(CappedMesh capped);

/// Extracts the mesh of a field's window, with normals. At least two nodes away from where the window cuts the domain,
/// the places, positions, normals and order are the same as in the whole mesh.
PlacedMesh extractPlacedMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                             Monitor& monitor);

/// Extracts the same in pieces.
MeshCounts extractPlacedMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                             PlacedMeshSink& sink, Monitor& monitor);

/// Extracts the mesh in pieces, with normals as computeNormals() makes them.
MeshCounts extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                       MeshSink& sink, Monitor& monitor);

/// Extracts the same mesh while F is evaluated. F is never held as a whole: memory holds a few layers of blocks in x.
/// Crumbs are dropped on the way, if the plan drops them.
MeshCounts streamMesh(const FieldPlan& plan, const FieldSource& source, const ExtractMeshOptions& options,
                      MeshSink& sink, Monitor& monitor);
MeshCounts streamPlacedMesh(const FieldPlan& plan, const FieldSource& source, const ExtractMeshOptions& options,
                            PlacedMeshSink& sink, Monitor& monitor);

struct StreamedSurface {
  MeshCounts mesh;
  openvdb::FloatGrid::Ptr levelSet;  ///< null if there is no triangle
};

/// Does what streamMesh() does with Border::Cap, and makes the level set of levelSet() on the way, with the same bits.
/// Neither the mesh nor F is held.
/// @param normals  whether the sink gets them
StreamedSurface streamSurface(const FieldPlan& plan, const FieldSource& source, double tolerance, bool normals,
                              MeshSink& sink, Monitor& monitor);

/// The direction of a sum of normals; up (y) if they cancel out.
openvdb::Vec3s unitNormal(const openvdb::Vec3d& sum);

/// Sets unit normals: the normalised sum of the normals of a point's triangles, weighted by area.
void computeNormals(Mesh& mesh);

}  // namespace vdbtools
