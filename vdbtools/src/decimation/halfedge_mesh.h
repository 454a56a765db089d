// SPDX-License-Identifier: Apache-2.0
/// @file halfedge_mesh.h
/// The mesh type for OpenMesh, with positions as doubles.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

namespace vdbtools {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

/// Prepares a mesh for decimation: all elements have a status, and faces have normals. Points keep their numbers.
/// @throw DataError  an edge of more than two triangles, or of two that run the same way; a point where sheets touch
HalfedgeMesh toHalfedges(const Mesh& mesh);

}  // namespace vdbtools
