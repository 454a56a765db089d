// SPDX-License-Identifier: Apache-2.0
/// @file decimate.h
/// Fewer triangles for the same shape, by OpenMesh.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstddef>

namespace vdbtools {

/// Collapses edges: first those shorter than @a shortest (world units), which are slivers, then those that move the
/// surface least (quadric error), until no more than @a triangles are left or no edge can be collapsed without harm to
/// the topology. Long thin triangles and folds are made only where nothing else is left to collapse, and edges of flat
/// triangles are flipped. The points that remain do not move. Closed 2-manifolds stay closed 2-manifolds, and the order
/// is deterministic. Normals, attributes and texture coordinates are dropped.
/// @throw DataError  an edge of more than two triangles, or of two that run the same way; a point where sheets touch
Mesh decimated(const Mesh& mesh, std::size_t triangles, double shortest);

}  // namespace vdbtools
