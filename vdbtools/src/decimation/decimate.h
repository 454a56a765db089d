// SPDX-License-Identifier: Apache-2.0
/// @file decimate.h
/// Reduces the number of triangles and preserves the shape, with OpenMesh.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstddef>

namespace vdbtools {

/// Collapses edges: first slivers, whose edges are shorter than @a shortest (world units), then those that move the
/// surface least (quadric error), until at most @a triangles are left or no edge can be collapsed without changing the
/// topology. Long thin triangles and folds are created only if nothing else is left to collapse, and edges of flat
/// triangles are flipped. The remaining points do not move. Closed 2-manifolds stay closed 2-manifolds, and the order
/// is deterministic. Normals, attributes and texture coordinates are dropped.
/// @throw DataError  an edge of more than two triangles, or of two that run the same way; a point where sheets touch
Mesh decimated(const Mesh& mesh, std::size_t triangles, double shortest);

}  // namespace vdbtools
