// SPDX-License-Identifier: Apache-2.0
/// @file extract_mesh.h
/// Marching cubes on the signs of F, each vertex searched on its lattice edge by evaluating the true F there: F is far
/// from linear between nodes ([Kim15], [KD20] Fig. 4).
///
/// The mesh is closed and 2-manifold away from the domain's border, oriented outward; vertices are shared, one for each
/// crossing edge. Ambiguous faces keep the inside corners apart. A vertex and the order of all of them depend on global
/// indices only: points and triangles come by the blocks of 8^3 nodes that their edges and cells begin in, these by x,
/// then y, then z.
#pragma once

#include "vdbtools/field/fractal_field.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"

namespace vdbtools {

/// What becomes of a set that the domain cuts.
enum class Border {
  Open,  ///< the mesh ends there
  Cap,   ///< the set is closed by a flat cap, half a voxel beyond the last nodes
};

struct ExtractMeshOptions {
  double tolerance = 1e-3;  ///< voxels: a vertex lies within this of a sign change of F; 2^-40 to 0.5
  Border border = Border::Open;
};

struct MeshCounts {
  std::uint64_t points = 0, triangles = 0;
  std::uint64_t evaluatedNodes = 0;  ///< of the lattice; 0 where the field was there before
};

/// The whole mesh, without normals.
/// @throw std::invalid_argument  tolerance out of its domain
/// @throw DataError              more points than 32-bit indices count
Mesh extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                 Monitor& monitor);

/// The same in pieces, with normals as computeNormals() makes them.
MeshCounts extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                       MeshSink& sink, Monitor& monitor);

/// The same mesh while F is evaluated, which is never held whole: memory follows the largest layers of blocks in x.
MeshCounts streamMesh(const FieldPlan& plan, const FieldSource& source, const ExtractMeshOptions& options,
                      MeshSink& sink, Monitor& monitor);

/// The direction of a sum of normals. Where they cancel out there is none; up is as good as any.
openvdb::Vec3s unitNormal(const openvdb::Vec3d& sum);

/// Sets unit normals: the sum of the normals of a point's triangles, weighted by area.
void computeNormals(Mesh& mesh);

}  // namespace vdbtools
