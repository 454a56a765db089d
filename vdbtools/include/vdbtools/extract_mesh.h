// SPDX-License-Identifier: Apache-2.0
/// @file extract_mesh.h
/// Marching cubes on the signs of F, each vertex searched on its lattice edge by evaluating the true F there: F is far
/// from linear between nodes ([Kim15], [KD20] Fig. 4).
///
/// The mesh is closed and 2-manifold away from the domain's border, oriented outward; vertices are shared, one for each
/// crossing edge. Ambiguous faces keep the inside corners apart. A vertex and the order of all of them depend on global
/// indices only.
#pragma once

#include "vdbtools/fractal_field.h"
#include "vdbtools/mesh.h"

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

/// @throw std::invalid_argument  tolerance out of its domain
/// @throw DataError              more points than 32-bit indices count
Mesh extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                 Monitor& monitor);

/// Sets unit normals: the sum of the normals of a point's triangles, weighted by area.
void computeNormals(Mesh& mesh);

}  // namespace vdbtools
