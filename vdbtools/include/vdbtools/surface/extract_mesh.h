// SPDX-License-Identifier: Apache-2.0
/// @file extract_mesh.h
/// The room `surface` turns a field into surfaces: a mesh whose vertices lie on the true F = 0, and the level set and
/// other grids that are handed on. It uses the rooms up to `field`.
///
/// Here: marching cubes on the signs of F, where each vertex is searched on its lattice edge by evaluating the true F,
/// as F is far from linear between nodes ([Kim15], [KD20] Fig. 4).
///
/// The mesh is closed and 2-manifold away from the domain's border, and oriented outward; vertices are shared, one for
/// each crossing edge. On ambiguous faces the inside corners are kept apart. Positions and order depend on global
/// indices only: points and triangles come by the blocks of 8^3 nodes that their edges and cells begin in, and the
/// blocks by x, then y, then z.
#pragma once

#include "vdbtools/field/fractal_field.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"

namespace vdbtools {

/// What happens to a set that the domain cuts.
enum class Border {
  Open,  ///< the mesh ends there
  Cap,   ///< the set is closed by a flat cap, half a voxel beyond the last nodes
};

struct ExtractMeshOptions {
  double tolerance = 1e-3;  ///< voxels: a vertex lies within this of a sign change of F; 2^-40 to 0.5
  Border border = Border::Open;
};

/// A whole mesh whose set is closed by caps where the domain cuts it.
struct CappedMesh {
  Mesh mesh;                ///< without normals
  std::vector<bool> onCap;  ///< whether each point lies on an edge that leaves the domain, so on a cap
};

/// The lattice edge that a point lies on.
struct EdgePlace {
  openvdb::Coord node;    ///< where it begins
  std::uint8_t axis = 0;  ///< along which it runs
  bool cut = false;       ///< whether it leaves the domain, so that the point lies on a cap
};

/// Where the points and the triangles of a mesh come from.
struct MeshPlaces {
  std::vector<EdgePlace> points;
  std::vector<openvdb::Coord> triangles;  ///< the first nodes of their cells
};

struct PlacedMesh {
  Mesh mesh;
  MeshPlaces places;
};

struct MeshCounts {
  std::uint64_t points = 0, triangles = 0;
  std::uint64_t evaluatedNodes = 0;     ///< of the lattice; 0 if the field was evaluated before
  std::optional<CrumbReport> crumbs{};  ///< that were dropped meanwhile, if the plan has it so
};

/// The whole mesh, without normals.
/// @throw std::invalid_argument  tolerance out of its domain
/// @throw DataError              more points than 32-bit indices count
Mesh extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                 Monitor& monitor);

/// The mesh with Border::Cap, from which withoutCaps() makes the other one without searching the edges again.
/// @throw as extractMesh()
CappedMesh extractCappedMesh(const FractalField& field, const FieldSource& source, double tolerance, Monitor& monitor);

/// The same mesh, to the bit, as extractMesh() makes with Border::Open.
Mesh withoutCaps(CappedMesh capped);

/// The mesh of a field's window, with normals. Of those that lie at least two nodes from where the window cuts the
/// domain, the places, positions, normals and the order are those of the whole.
PlacedMesh extractPlacedMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                             Monitor& monitor);

/// The mesh in pieces, with normals as computeNormals() makes them.
MeshCounts extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                       MeshSink& sink, Monitor& monitor);

/// The same mesh, made while F is evaluated. F is never held whole: memory holds a few layers of blocks in x. Crumbs
/// are dropped on the way, where the plan drops them.
MeshCounts streamMesh(const FieldPlan& plan, const FieldSource& source, const ExtractMeshOptions& options,
                      MeshSink& sink, Monitor& monitor);

/// The direction of a sum of normals; up (y) where they cancel out.
openvdb::Vec3s unitNormal(const openvdb::Vec3d& sum);

/// Sets unit normals: the sum of the normals of a point's triangles, weighted by area.
void computeNormals(Mesh& mesh);

}  // namespace vdbtools
